"""A recording on disk, in the layout of the EuRoC datasets: what the robots' cameras and wheels told, and never the truth.

* robots.yaml                 how the robots are built and where they start
* <robot>/cam0/sensor.yaml    calibration, for the agent to read
* <robot>/cam0/data.csv       #timestamp [ns],filename        pictures lie in <robot>/cam0/data/
* <robot>/wheels0/data.csv    #timestamp [ns],left [rad],right [rad]
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from protocol.errors import RecordingError
from sim.rigs import RobotRig, read_rigs
from sim.tables import file_name, finite_number, read_rows

_WHEELS_MAY_END_EARLY_NS = 100_000_000  # five periods of 50 Hz: less is how any two drivers stop


class CameraRow(NamedTuple):
    """One line of a camera's data.csv."""

    stamp_ns: int
    picture: Path  # may name a file that is not there


@dataclass(frozen=True)
class WheelRows:
    """Encoder readings of one robot, oldest first."""

    stamps_ns: NDArray[np.int64]  # (n,) strictly increasing
    angles_rad: NDArray[np.float64]  # (n, 2) left, right; cumulative

    def between(self, after_ns: int, until_ns: int) -> WheelRows:
        """Return the readings with after_ns < stamp <= until_ns."""
        first, end = np.searchsorted(self.stamps_ns, [after_ns, until_ns], side="right")
        return WheelRows(self.stamps_ns[first:end], self.angles_rad[first:end])


@dataclass(frozen=True)
class RecordedRobot:
    """One robot of a recording."""

    rig: RobotRig
    sensor_file: Path
    camera: tuple[CameraRow, ...]
    wheels: WheelRows

    @property
    def name(self) -> str:
        """The robot's name."""
        return self.rig.name


@dataclass(frozen=True)
class Step:
    """Everything captured at one stamp, and what every robot's wheels told since the step before."""

    stamp_ns: int
    pictures: Mapping[str, Path]  # of the robots whose cameras fired, in order of name
    wheels: Mapping[str, WheelRows]  # of all robots

    @property
    def fired(self) -> tuple[str, ...]:
        """The robots whose cameras fired, in order of name."""
        return tuple(self.pictures)


@dataclass(frozen=True)
class Recording:
    """A recording whose tables have been read and checked; pictures stay on disk."""

    folder: Path
    robots: tuple[RecordedRobot, ...]  # in order of robots.yaml
    team_patch_rgb: tuple[int, int, int] | None
    warnings: tuple[str, ...]  # what is odd but can be lived with, one line each

    @classmethod
    def open(cls, folder: Path) -> Recording:
        """Read a recording; raises RecordingError that names file and field where it cannot be used."""
        if not folder.is_dir():
            raise RecordingError(f"{folder}: no such folder; give the folder that holds robots.yaml")
        rigs = read_rigs(folder)
        robots = tuple(_read_robot(folder, rig) for rig in rigs.robots)
        warnings = tuple(line for robot in robots for line in _warnings(folder, robot))
        return cls(folder, robots, rigs.team_patch_rgb, warnings)

    @property
    def names(self) -> tuple[str, ...]:
        """The robots' names, in order of robots.yaml."""
        return tuple(robot.name for robot in self.robots)

    def without_starts(self, robots: Collection[str]) -> Recording:
        """Return the recording as if nobody knew where some robots start."""
        return replace(self, robots=tuple(_without_start(robot) if robot.name in robots else robot for robot in self.robots))

    def steps(self) -> list[Step]:
        """Return the recording as its steps, in order of time."""
        return group_steps(self.robots)


def group_steps(robots: Sequence[RecordedRobot]) -> list[Step]:
    """Gather what all robots captured at the same stamp; wheel readings go to the first step at or after them."""
    by_name = sorted(robots, key=lambda robot: robot.name)
    pictures: dict[int, dict[str, Path]] = {}
    for robot in by_name:
        for row in robot.camera:
            pictures.setdefault(row.stamp_ns, {})[robot.name] = row.picture
    stamps = sorted(pictures)
    return [
        Step(stamp, pictures[stamp], {robot.name: robot.wheels.between(previous, stamp) for robot in by_name})
        for previous, stamp in pairwise([-1, *stamps])
    ]


def _without_start(robot: RecordedRobot) -> RecordedRobot:
    return replace(robot, rig=robot.rig.model_copy(update={"initial_pose": None}))


def _read_robot(folder: Path, rig: RobotRig) -> RecordedRobot:
    sensor = f"{rig.name}/cam0/sensor.yaml"
    if not (folder / sensor).is_file():
        raise RecordingError(f"{sensor}: the calibration of {rig.name}'s camera is missing from {folder}")
    return RecordedRobot(rig, folder / sensor, _read_camera(folder, rig.name), _read_wheels(folder, rig.name))


def _read_camera(folder: Path, robot: str) -> tuple[CameraRow, ...]:
    table = f"{robot}/cam0/data.csv"
    rows = read_rows(folder, table, ("filename",), file_name)
    if not rows:
        raise RecordingError(f"{table}: holds no rows, so {robot} has no frame")
    pictures = folder / robot / "cam0" / "data"
    return tuple(CameraRow(stamp_ns, pictures / picture) for stamp_ns, [picture] in rows)


def _read_wheels(folder: Path, robot: str) -> WheelRows:
    rows = read_rows(folder, f"{robot}/wheels0/data.csv", ("left [rad]", "right [rad]"), finite_number)
    stamps = np.array([stamp_ns for stamp_ns, _ in rows], dtype=np.int64)
    angles = np.array([both for _, both in rows], dtype=np.float64).reshape(-1, 2)
    return WheelRows(stamps, angles)


def _warnings(folder: Path, robot: RecordedRobot) -> list[str]:
    return [line for line in (_wheels_that_stop_early(robot), _missing_pictures(folder, robot)) if line]


def _wheels_that_stop_early(robot: RecordedRobot) -> str:
    table = f"{robot.name}/wheels0/data.csv"
    if len(robot.wheels.stamps_ns) == 0:
        return f"{table}: holds no rows; {robot.name} has no wheel data"
    missing_ns = robot.camera[-1].stamp_ns - int(robot.wheels.stamps_ns[-1])
    if missing_ns <= _WHEELS_MAY_END_EARLY_NS:
        return ""
    return f"{table}, timestamp [ns]: wheel data stop {missing_ns / 1e9:.2f} s before the last frame"


def _missing_pictures(folder: Path, robot: RecordedRobot) -> str:
    missing = [row.picture for row in robot.camera if not row.picture.is_file()]
    if not missing:
        return ""
    first = missing[0].relative_to(folder).as_posix()
    return f"{robot.name}/cam0/data.csv, filename: {len(missing)} of {len(robot.camera)} pictures are missing, the first is {first}"
