"""A folder of the UTIAS multi-robot data set: what the robots' odometry and range-bearing sensors told, and never the truth.

* Barcodes.dat                subject, barcode                      robots are subjects 1 to 5, landmarks the others
* Robot<n>_Odometry.dat       time [s], forward speed [m/s], turn rate [rad/s]
* Robot<n>_Measurement.dat    time [s], barcode, range [m], bearing [rad]

Leung, Halpern, Barfoot, Liu, "The UTIAS multi-robot cooperative localization and mapping dataset", IJRR 2011. Robot n is called rn here.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from protocol.errors import RecordingError
from protocol.messages import Identity
from sim.mrclam_tables import read_table

BARCODES_FILE = "Barcodes.dat"
MAX_ROBOTS = 5  # subjects 1 to 5 are robots in every set
STEP_NS = 500_000_000  # a robot says what it knows twice a second
_SUBJECTS = ("subject", "barcode")
_ODOMETRY = ("time [s]", "forward speed [m/s]", "turn rate [rad/s]")
_MEASUREMENT = ("time [s]", "barcode", "range [m]", "bearing [rad]")


@dataclass(frozen=True)
class Readings:
    """What one robot was told, oldest first."""

    twist_stamps_ns: NDArray[np.int64]  # (n,)
    twists: NDArray[np.float64]  # (n, 2) forward [m/s], turn [rad/s]
    sighting_stamps_ns: NDArray[np.int64]  # (m,)
    sightings: NDArray[np.float64]  # (m, 2) range [m], bearing [rad]
    identities: tuple[Identity, ...]  # (m,)

    def between(self, after_ns: int, until_ns: int) -> Readings:
        """Return what was told at after_ns < stamp <= until_ns."""
        first, end = np.searchsorted(self.twist_stamps_ns, [after_ns, until_ns], side="right")
        begin, stop = np.searchsorted(self.sighting_stamps_ns, [after_ns, until_ns], side="right")
        return Readings(
            self.twist_stamps_ns[first:end],
            self.twists[first:end],
            self.sighting_stamps_ns[begin:stop],
            self.sightings[begin:stop],
            self.identities[begin:stop],
        )


@dataclass(frozen=True)
class ReadingsStep:
    """What the robots were told since the step before; those in it say at this stamp what they know."""

    stamp_ns: int
    readings: Mapping[str, Readings]  # of the robots that have begun, in order of name

    @property
    def fired(self) -> tuple[str, ...]:
        """The robots that say something at this stamp."""
        return tuple(self.readings)


@dataclass(frozen=True)
class MrclamRecording:
    """A folder whose tables have been read and checked."""

    folder: Path
    robots: Mapping[str, Readings]  # by name, in order of name
    warnings: tuple[str, ...]  # what is odd but can be lived with, one line each

    @classmethod
    def open(cls, folder: Path) -> MrclamRecording:
        """Read a folder; raises RecordingError that names file, line and column where it cannot be used."""
        if not (folder / BARCODES_FILE).is_file():
            raise RecordingError(f"{folder}: holds no {BARCODES_FILE}; give a folder of the UTIAS MRCLAM data set")
        subjects = _read_subjects(folder)
        numbers = [number for number in range(1, MAX_ROBOTS + 1) if (folder / _odometry(number)).is_file()]
        if not numbers:
            raise RecordingError(f"{folder}: holds no {_odometry(1)}, so there is no robot")
        robots: dict[str, Readings] = {}
        warnings: list[str] = []
        for number in numbers:
            robots[robot_name(number)], unknown = _read_robot(folder, number, subjects)
            if unknown:
                warnings.append(f"{_measurement(number)}: {unknown} readings of barcodes that {BARCODES_FILE} does not name are left out")
        return cls(folder, robots, tuple(warnings))

    @property
    def names(self) -> tuple[str, ...]:
        """The robots' names."""
        return tuple(self.robots)

    def steps(self) -> list[ReadingsStep]:
        """Return the recording as its steps, `STEP_NS` apart; a robot is in them from its first to its last odometry."""
        first_ns = min(int(robot.twist_stamps_ns[0]) for robot in self.robots.values())
        last_ns = max(int(robot.twist_stamps_ns[-1]) for robot in self.robots.values())
        stamps = range(-(-first_ns // STEP_NS) * STEP_NS, last_ns + 1, STEP_NS)
        return [ReadingsStep(stamp_ns, self._told(stamp_ns)) for stamp_ns in stamps]

    def frames(self) -> dict[str, int]:
        """Return how many local maps each robot has to send."""
        steps = self.steps()
        return {name: sum(name in step.readings for step in steps) for name in self.names}

    def _told(self, stamp_ns: int) -> dict[str, Readings]:
        working = {name: robot for name, robot in self.robots.items() if _is_on(robot, stamp_ns)}
        return {name: robot.between(_previous_ns(robot, stamp_ns), stamp_ns) for name, robot in working.items()}


def robot_name(number: int) -> str:
    """Return how the robot with this subject number is called."""
    return f"r{number}"


def _is_on(robot: Readings, stamp_ns: int) -> bool:
    return bool(robot.twist_stamps_ns[0] <= stamp_ns <= robot.twist_stamps_ns[-1])


def _previous_ns(robot: Readings, stamp_ns: int) -> int:
    """Return the stamp of the step before; nothing of a robot is known before its odometry begins."""
    return max(stamp_ns - STEP_NS, int(robot.twist_stamps_ns[0]) - 1)


def _odometry(number: int) -> str:
    return f"Robot{number}_Odometry.dat"


def _measurement(number: int) -> str:
    return f"Robot{number}_Measurement.dat"


def _read_subjects(folder: Path) -> dict[int, Identity]:
    """Return what carries each barcode."""
    rows = read_table(folder, BARCODES_FILE, _SUBJECTS)
    subjects = {int(barcode): _identity(int(subject)) for subject, barcode in rows.tolist()}
    if len(subjects) < len(rows):
        raise RecordingError(f"{BARCODES_FILE}, barcode: the same barcode stands twice")
    return subjects


def _identity(subject: int) -> Identity:
    if subject <= MAX_ROBOTS:
        return Identity(kind="robot", name=robot_name(subject))
    return Identity(kind="landmark", name=str(subject))


def _read_robot(folder: Path, number: int, subjects: Mapping[int, Identity]) -> tuple[Readings, int]:
    """Return what a robot was told, and how many of its readings show a barcode that nobody carries."""
    odometry = read_table(folder, _odometry(number), _ODOMETRY, stamped=True)
    if not len(odometry):
        raise RecordingError(f"{_odometry(number)}: holds no rows, so {robot_name(number)} has no odometry")
    measured = read_table(folder, _measurement(number), _MEASUREMENT, stamped=True)
    if (measured[:, 2] <= 0.0).any():
        raise RecordingError(f"{_measurement(number)}, range [m]: a range has to be above 0")
    known = np.array([int(barcode) in subjects for barcode in measured[:, 1]], dtype=bool)
    read = measured[known]
    readings = Readings(
        _stamps_ns(odometry),
        odometry[:, 1:3],
        _stamps_ns(read),
        read[:, 2:4],
        tuple(subjects[int(barcode)] for barcode in read[:, 1]),
    )
    return readings, int((~known).sum())


def _stamps_ns(rows: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return the first column as whole nanoseconds; the files hold milliseconds."""
    return np.rint(rows[:, 0] * 1e3).astype(np.int64) * 1_000_000
