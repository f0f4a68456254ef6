"""The ground truth of a folder of the UTIAS data set: where a motion capture system saw the robots. For scoring only."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from deploy.evaluation.tum import Trajectory
from protocol.errors import RecordingError
from sim.mrclam import BARCODES_FILE, MAX_ROBOTS, robot_name
from sim.mrclam_tables import read_table

MAX_GAP_NS = 500_000_000  # nothing is known of a robot between two sightings that lie farther apart
_COLUMNS = ("time [s]", "x [m]", "y [m]", "orientation [rad]")


def is_mrclam(folder: Path) -> bool:
    """Tell whether a folder is one of the UTIAS data set."""
    return (folder / BARCODES_FILE).is_file()


def read_mrclam_truth(folder: Path) -> dict[str, Trajectory]:
    """Return the true paths by robot; RecordingError, one line, where there are none or one cannot be used."""
    numbers = [number for number in range(1, MAX_ROBOTS + 1) if (folder / _file(number)).is_file()]
    if not numbers:
        raise RecordingError(f"{folder}: holds no {_file(1)}, so there is no truth to judge by")
    return {robot_name(number): _read(folder, number) for number in numbers}


def true_positions(truth: Trajectory, stamps_ns: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return where a robot truly was, shape (n, 2) [m], between the sightings around each stamp; NaN in gaps, before and after."""
    times = truth.stamps_ns
    after = np.clip(np.searchsorted(times, stamps_ns), 1, len(times) - 1)
    known = (stamps_ns >= times[0]) & (stamps_ns <= times[-1]) & (times[after] - times[after - 1] <= MAX_GAP_NS)
    seconds, asked_s = (times - times[0]) * 1e-9, (stamps_ns - times[0]) * 1e-9
    positions = np.column_stack([np.interp(asked_s, seconds, truth.poses[:, axis]) for axis in (0, 1)])
    positions[~known] = np.nan
    return positions


def _file(number: int) -> str:
    return f"Robot{number}_Groundtruth.dat"


def _read(folder: Path, number: int) -> Trajectory:
    table = read_table(folder, _file(number), _COLUMNS, stamped=True)
    if len(table) < 2:
        raise RecordingError(f"{_file(number)}: holds less than two rows")
    return Trajectory(np.rint(table[:, 0] * 1e3).astype(np.int64) * 1_000_000, table[:, 1:4])
