"""Trajectories in the TUM format: one line a pose, `timestamp[s] x y z qx qy qz qw`, lines with # are comments."""

from __future__ import annotations

import math
from dataclasses import dataclass
from decimal import Decimal, InvalidOperation
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from deploy.evaluation.reading import read_text
from protocol.errors import RecordingError

FIELDS = ("timestamp", "x", "y", "z", "qx", "qy", "qz", "qw")
MAX_NUMBER = 9_000_000_000  # seconds that 64 bits of nanoseconds hold, and far more metres than any floor has


@dataclass(frozen=True)
class Trajectory:
    """One robot's poses over time, stamps strictly growing."""

    stamps_ns: NDArray[np.int64]  # (n,)
    poses: NDArray[np.float64]  # (n, 3) x [m], y [m], theta [rad; arena], theta in (-pi, pi]

    def __len__(self) -> int:
        """Return the number of poses."""
        return len(self.stamps_ns)


def no_poses() -> Trajectory:
    """Return the trajectory of a robot that nothing is known of."""
    return Trajectory(np.empty(0, dtype=np.int64), np.empty((0, 3)))


def read_tum(file: Path) -> Trajectory:
    """Return the planar part of a TUM file; RecordingError names the line and field that cannot be used."""
    stamps_ns: list[int] = []
    poses: list[tuple[float, float, float]] = []
    for number, line in enumerate(read_text(file).splitlines(), start=1):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        stamp_ns, pose = _parse_line(f"{file}:{number}", line)
        if stamps_ns and stamp_ns <= stamps_ns[-1]:
            raise RecordingError(f"{file}:{number}: timestamp: does not grow")
        stamps_ns.append(stamp_ns)
        poses.append(pose)
    return Trajectory(np.array(stamps_ns, dtype=np.int64), np.array(poses, dtype=np.float64).reshape(-1, 3))


def _parse_line(place: str, line: str) -> tuple[int, tuple[float, float, float]]:
    words = line.split()
    if len(words) != len(FIELDS):
        raise RecordingError(f"{place}: has {len(words)} fields, a TUM line has {len(FIELDS)} ({' '.join(FIELDS)})")
    stamp, x_m, y_m, _, qx, qy, qz, qw = (_parse_number(f"{place}: {field}", word) for field, word in zip(FIELDS, words, strict=True))
    if qx == qy == qz == qw == 0:
        raise RecordingError(f"{place}: qw: a quaternion of zeros is no rotation")
    return int(stamp * 1_000_000_000), (float(x_m), float(y_m), _yaw(float(qx), float(qy), float(qz), float(qw)))


def _parse_number(place: str, word: str) -> Decimal:
    """Return a finite number exactly as written: binary floats round stamps of today to 0.2 microseconds."""
    try:
        number = Decimal(word)
    except InvalidOperation as error:
        raise RecordingError(f"{place}: {word!r} is not a number") from error
    if not number.is_finite() or abs(number) > MAX_NUMBER:
        raise RecordingError(f"{place}: {word!r} is out of range")
    return number


def _yaw(qx: float, qy: float, qz: float, qw: float) -> float:
    """Return the rotation about z [rad], the first of yaw, pitch and roll; any scale of the quaternion will do."""
    return math.atan2(2.0 * (qw * qz + qx * qy), qw * qw + qx * qx - qy * qy - qz * qz)
