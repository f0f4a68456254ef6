"""How well the robots held their slots, by the world's truth: each follower's distance from its slot, laid at the true leader.

What the formation did is read from formation.csv (formation_log.py), where the robots truly were from the recording's ground truth.
"""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from itertools import groupby, pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from deploy.evaluation.formation_restored import Whole, how_whole, restored_s
from deploy.evaluation.formation_room import OpenSlots
from deploy.evaluation.reading import read_text
from deploy.evaluation.tum import Trajectory
from deploy.formation_log import FORMATION_FILE, HEADER
from protocol.errors import RecordingError
from protocol.geometry import Pose2

STEADY, AVOIDING = ("moving", "exploring", "returning"), ("avoiding",)
OpenSlotsAt = Callable[[str, int], OpenSlots | None]  # for a leader and a stamp; None where nobody knows them


class SlotRow(NamedTuple):
    """One follower's slot at one stamp."""

    stamp_ns: int
    phase: str
    leader: str
    robot: str
    leader_from_slot_m: tuple[float, float]


@dataclass(frozen=True)
class FormationScore:
    """How well a formation was held."""

    steady_rms_m: float  # NaN where it was never so
    avoiding_rms_m: float
    worst_m: float  # of a follower, in either
    steady_s: float
    avoiding_s: float
    restored_s: tuple[float, ...]  # how long the formation took to be whole again once there was room, each time that it gave way
    phases: tuple[str, ...]  # one after the other


def read_slots(run: Path) -> list[SlotRow]:
    """Return what formation.csv tells, in its order; nothing where the run has none; RecordingError names a line that cannot be used."""
    file = run / FORMATION_FILE
    if not file.exists():
        return []
    header, *lines = read_text(file).splitlines()
    if header != HEADER:
        raise RecordingError(f"{file}:1: is {header!r}, not {HEADER!r}")
    return [_row(file, number, fields) for number, fields in enumerate(csv.reader(lines), start=2)]


def score_formation(
    rows: Iterable[SlotRow], truth: Mapping[str, Trajectory], open_slots: OpenSlotsAt = lambda leader, stamp_ns: None
) -> FormationScore | None:
    """Return the score; None where there is no follower with a slot. `open_slots` tells where the whole formation would have been."""
    paths = {robot: dict(zip(path.stamps_ns.tolist(), path.poses.tolist(), strict=True)) for robot, path in truth.items()}
    moments = [_moment(list(group), paths, open_slots) for _, group in groupby(rows, key=lambda row: row.stamp_ns)]
    errors = {name: _of(moments, phases) for name, phases in (("steady", STEADY), ("avoiding", AVOIDING))}
    both = np.concatenate(list(errors.values()))
    if not len(both):
        return None
    return FormationScore(
        steady_rms_m=_rms(errors["steady"]),
        avoiding_rms_m=_rms(errors["avoiding"]),
        worst_m=float(both.max()),
        steady_s=_lasting_s(moments, STEADY),
        avoiding_s=_lasting_s(moments, AVOIDING),
        restored_s=tuple(restored_s(moment.whole for moment in moments)),
        phases=tuple(phase for phase, _ in groupby(moment.phase for moment in moments)),
    )


class _Moment(NamedTuple):
    stamp_ns: int
    phase: str
    errors_m: NDArray[np.float64]  # (followers,)
    whole: Whole


def _moment(rows: list[SlotRow], paths: Mapping[str, Mapping[int, list[float]]], open_slots: OpenSlotsAt) -> _Moment:
    stamp_ns, phase, leader, _, _ = rows[0]
    followers = [row for row in rows if row.robot != leader and stamp_ns in paths.get(row.robot, {})]
    if not followers or stamp_ns not in paths.get(leader, {}):
        return _Moment(stamp_ns, phase, np.empty(0), how_whole(stamp_ns, np.empty((0, 2)), None))
    slots = Pose2(*paths[leader][stamp_ns]).apply([row.leader_from_slot_m for row in followers])
    places = np.array([paths[row.robot][stamp_ns][:2] for row in followers])
    whole = how_whole(stamp_ns, places, open_slots(leader, stamp_ns) if phase in STEADY + AVOIDING else None)
    return _Moment(stamp_ns, phase, np.hypot(*(places - slots).T), whole)


def _of(moments: Iterable[_Moment], phases: tuple[str, ...]) -> NDArray[np.float64]:
    return np.concatenate([np.empty(0), *(moment.errors_m for moment in moments if moment.phase in phases)])


def _rms(errors_m: NDArray[np.float64]) -> float:
    return float(np.sqrt(np.mean(errors_m**2))) if len(errors_m) else float("nan")


def _lasting_s(moments: list[_Moment], phases: tuple[str, ...]) -> float:
    pairs = pairwise(moments)
    return sum((after.stamp_ns - before.stamp_ns) / 1e9 for before, after in pairs if before.phase in phases)


def _row(file: Path, number: int, fields: list[str]) -> SlotRow:
    try:
        stamp, phase, leader, robot, x_m, y_m = fields
        return SlotRow(int(stamp), phase, leader, robot, (float(x_m), float(y_m)))
    except ValueError:
        raise RecordingError(f"{file}:{number}: {','.join(fields)!r} does not fit {HEADER!r}") from None
