"""A small folder in the format of the UTIAS data set: robots that drive circles among landmarks, written with its truth."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from protocol.geometry import Pose2

START_S = 1_248_444_100.0
ODOMETRY_HZ, SIGHTING_HZ = 50, 4
LANDMARKS = {6: (3.0, 0.5), 7: (0.5, 3.0), 8: (-2.5, 1.5), 9: (-1.0, -2.5), 10: (2.0, -2.0)}
STARTS = {1: Pose2(0.5, -1.0, 0.3), 2: Pose2(-1.5, 0.5, -1.0), 3: Pose2(1.0, 1.0, 2.0)}
SPEEDS = {1: (0.10, 0.10), 2: (0.12, -0.09), 3: (0.08, 0.12)}  # forward [m/s], turn [rad/s]
VIEW_RAD = math.radians(70.0)  # to either side
HEADER = "# UTIAS Multi-Robot Cooperative Localization and Mapping Dataset\n"


def barcode(subject: int) -> int:
    """Return what a subject carries: no barcode is its subject's number."""
    return 100 - subject


def true_pose(robot: int, elapsed_s: float) -> Pose2:
    """Return where a robot is: all drive on circles from the first second on."""
    forward_m_s, turn_rad_s = SPEEDS[robot]
    return STARTS[robot] @ Pose2.exp((forward_m_s * elapsed_s, 0.0, turn_rad_s * elapsed_s))


def write_folder(folder: Path, duration_s: float = 30.0, seed: int = 1) -> Path:
    """Write all files; odometry tells 2 % too much, ranges err by 3 cm and bearings by 0.01 rad."""
    folder.mkdir()
    random = np.random.default_rng(seed)
    subjects = [*STARTS, *LANDMARKS]
    _write(folder / "Barcodes.dat", [f"{subject} \t {barcode(subject)}" for subject in subjects])
    _write(folder / "Landmark_Groundtruth.dat", [f"{number} {x} {y} 0.0001 0.0001" for number, (x, y) in LANDMARKS.items()])
    for robot in STARTS:
        times = np.arange(0.0, duration_s, 1.0 / ODOMETRY_HZ)
        forward_m_s, turn_rad_s = SPEEDS[robot]
        _write(folder / f"Robot{robot}_Odometry.dat", [f"{START_S + t:.3f} \t {1.02 * forward_m_s:.5f} {turn_rad_s:.5f}" for t in times])
        truth = [(t, true_pose(robot, t)) for t in times]
        _write(folder / f"Robot{robot}_Groundtruth.dat", [f"{START_S + t:.3f} {p.x_m:.8f} {p.y_m:.8f} {p.theta_rad:.8f}" for t, p in truth])
        _write(folder / f"Robot{robot}_Measurement.dat", _sightings(robot, duration_s, random))
    return folder


def _sightings(robot: int, duration_s: float, random: np.random.Generator) -> list[str]:
    lines = []
    for elapsed_s in np.arange(0.1, duration_s, 1.0 / SIGHTING_HZ):
        body_from_arena = true_pose(robot, elapsed_s).inverse()
        others = {other: true_pose(other, elapsed_s)[:2] for other in STARTS if other != robot}
        for subject, place in {**LANDMARKS, **others}.items():
            x_m, y_m = body_from_arena.apply(place)
            if abs(math.atan2(y_m, x_m)) <= VIEW_RAD:
                range_m, bearing_rad = math.hypot(x_m, y_m) + random.normal(0.0, 0.03), math.atan2(y_m, x_m) + random.normal(0.0, 0.01)
                lines.append(f"{START_S + elapsed_s:.3f} \t {barcode(subject)} \t {range_m:.3f} {bearing_rad:.3f}")
    return lines


def _write(file: Path, lines: list[str]) -> None:
    file.write_text(HEADER + "\n".join(lines) + "\n", encoding="utf-8")
