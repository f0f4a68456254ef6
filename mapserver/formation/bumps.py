"""What robots have come up against: one that cannot follow its reference has something before it, though the map may not show it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from mapserver.formation.costmap import CostMap, Disc
from mapserver.formation.task import Moment
from mapserver.formation.trail import Reference
from protocol.geometry import Array, Pose2

BEHIND_M = 0.05  # from its reference: a robot that is driving does not fall back so far ...
STILL_M = 0.01  # ... while it stays where it is
HELD_S = 5.0  # in all: by then the formation has formed up anew, and the new plan led there again
THING_RADIUS_M, MARGIN_M = 0.04, 0.02  # of what is taken to stand there, and its distance from the robot that it holds up
KNOWN_M = 0.03  # from what the map shows: then that is what holds the robot up
MET_M = 0.12  # between the bodies of robots that may be in each other's way
LASTS_NS = 30_000_000_000


class _Hold(NamedTuple):
    place: Pose2
    held_s: float


class _Bump(NamedTuple):
    thing: Disc
    stamp_ns: int


class Bumps:
    """Remembers for a while where robots were held up."""

    def __init__(self, radius_m: float) -> None:
        """All robots are as wide as the widest."""
        self._radius_m = radius_m
        self._holds: dict[str, _Hold] = {}  # where each robot is, and for how long it could not go on from there
        self._last_ns: int | None = None
        self._bumps: list[_Bump] = []

    def note(self, moment: Moment, references: Mapping[str, Reference], cost_map: CostMap) -> None:
        """Take in where the robots are, given what they were last told to follow, and the map without bumps."""
        self._bumps = [bump for bump in self._bumps if moment.stamp_ns - bump.stamp_ns <= LASTS_NS]
        elapsed_s = 0.0 if self._last_ns is None else min((moment.stamp_ns - self._last_ns) * 1e-9, 1.0)
        self._last_ns = moment.stamp_ns
        self._holds = {name: self._hold(name, pose, references.get(name), elapsed_s) for name, pose in moment.poses.items()}
        for name, hold in self._holds.items():
            if name in references and hold.held_s >= HELD_S:
                self._come_up_against(name, references[name].arena_from_body, moment, cost_map)

    def things(self) -> Sequence[Disc]:
        """Return what is taken to stand where robots were held up."""
        return [bump.thing for bump in self._bumps]

    def _hold(self, name: str, pose: Pose2, reference: Reference | None, elapsed_s: float) -> _Hold:
        was = self._holds.get(name)
        if was is None or math.dist(was.place[:2], pose[:2]) > STILL_M:
            return _Hold(pose, 0.0)
        is_behind = reference is not None and math.dist(reference.arena_from_body[:2], pose[:2]) >= BEHIND_M
        return was._replace(held_s=was.held_s + elapsed_s) if is_behind else was

    def _come_up_against(self, name: str, reference: Pose2, moment: Moment, cost_map: CostMap) -> None:
        """Note a thing between a robot and its reference, unless the map, or another robot, says what holds it up."""
        place_m = np.array(moment.poses[name][:2])
        way_m = np.array(reference[:2]) - place_m
        behind_m = float(np.hypot(*way_m))
        if behind_m < BEHIND_M:
            return
        centre_m = place_m + way_m / behind_m * (self._radius_m + MARGIN_M + THING_RADIUS_M)
        others = [pose for other, pose in {**moment.poses, **moment.lost}.items() if other != name]
        if not self._is_known(centre_m, others, moment.moving, cost_map):
            self._bumps = [bump for bump in self._bumps if math.dist(bump.thing.centre_m, centre_m) > THING_RADIUS_M]
            self._bumps.append(_Bump(Disc(centre_m, THING_RADIUS_M), moment.stamp_ns))

    def _is_known(self, centre_m: Array, others: Sequence[Pose2], moving: Sequence[Array], cost_map: CostMap) -> bool:
        met_m = self._radius_m + THING_RADIUS_M + MET_M
        is_met = any(math.dist(pose[:2], centre_m) < met_m for pose in others)
        is_passed = any(float(np.hypot(*(footprint_m - centre_m).T).min()) < met_m for footprint_m in moving)
        return is_met or is_passed or float(cost_map.clearance_m(centre_m)) < KNOWN_M
