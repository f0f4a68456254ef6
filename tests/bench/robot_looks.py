"""`python -m tests.bench.robot_looks RECORDING...`: how well robots are told from other things, and the weights that tell them best.

In every picture a robot's silhouette is fitted wherever it is likely; by the true poses each fit is a robot or none. Printed are the
weights of agent/vision/robot_evidence.py as logistic regression finds them, and what share of both is taken for robots with the weights
that are in use.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from agent.drivers.bus_camera import captured
from agent.optics import Optics
from agent.vision.floor_removal import FloorColours
from agent.vision.robot_evidence import LEAST_SHOWN, looks, robot_evidence
from agent.vision.robot_scan import SECTORS, RobotScan
from protocol.geometry import Array
from tests.bench.frames import Case, Subject, open_case
from tests.bench.on_recordings import print_table
from tests.bench.true_robots import TrueRobots, stands_there

EVERY = 3  # frames: from one to the next little changes
ROUNDS, RIDGE = 30, 1e-2
NAMES = ("shown", "beside", "misfit [px]", "change", "1")


class Looks(NamedTuple):
    """What was fitted, n times."""

    seen: Array  # (n, 5) as `looks` returns it
    evidence: Array  # (n,) with the weights in use
    is_robot: NDArray[np.bool_]  # (n,)


def main() -> int:
    """Take all recordings together, print the table and the weights, and return the exit code."""
    every: list[Looks] = []

    def row(recording: Path) -> str:
        every.append(_looks(open_case(recording), recording))
        return _row(recording.resolve().name, every[-1])

    header = "| recording | robots | taken for one | other things | taken for one |"
    if exit_code := print_table("robot_looks", __doc__, header, row):
        return exit_code
    shown = np.concatenate([each.seen for each in every]), np.concatenate([each.is_robot for each in every])
    for name, weight in zip(NAMES, weights(*shown).tolist(), strict=True):
        print(f"{name:12} {weight:6.1f}")
    return 0


def weights(seen: Array, is_robot: NDArray[np.bool_]) -> Array:
    """Return the weights, (m,), of looks (n, m) whose sum best tells robots, both kinds counting the same: logistic regression."""
    spread = np.maximum(seen.std(axis=0), 1e-9)
    spread[-1] = 1.0
    terms, found = seen / spread, np.zeros(seen.shape[1])
    counts = np.where(is_robot, 0.5 / is_robot.mean(), 0.5 / (~is_robot).mean())
    for _ in range(ROUNDS):
        likely = 1.0 / (1.0 + np.exp(-np.clip(terms @ found, -30.0, 30.0)))
        slope = terms.T @ (counts * (is_robot - likely)) - RIDGE * found
        bend = (terms * (counts * likely * (1.0 - likely))[:, None]).T @ terms + RIDGE * np.eye(len(found))
        found = found + np.linalg.solve(bend, slope)
    return np.asarray(found / spread)


def _row(name: str, found: Looks) -> str:
    is_taken = found.evidence > 0.0
    cells: list[str] = []
    for kind in (found.is_robot, ~found.is_robot):
        cells += [str(int(kind.sum())), f"{is_taken[kind].mean():.1%}" if kind.any() else "-"]
    return f"| {name} | {' | '.join(cells)} |"


def _looks(case: Case, recording: Path) -> Looks:
    truth = TrueRobots(recording, (subject.name for subject in case.subjects))
    rows: list[tuple[Array, float, bool]] = []
    for subject in case.subjects:
        for stamp_ns, found in _fits(case, subject):
            robots_m = truth.others_m(subject.name, stamp_ns)
            rows += [(seen, told, stands_there(robots_m, place_m)) for place_m, seen, told in found]
    return Looks(np.array([row[0] for row in rows]), np.array([row[1] for row in rows]), np.array([row[2] for row in rows]))


def _fits(case: Case, subject: Subject) -> Iterator[tuple[int, list[tuple[Array, Array, float]]]]:
    """Yield the stamp of every so many pictures, and what is fitted in it: its place, (2,) [m; body], its looks, and its evidence."""
    body, optics = subject.body, Optics.of(subject.calibration, subject.body)
    scan = RobotScan(optics.projection, body.body_radius_m, body.body_height_m)
    colours: FloorColours | None = None
    for number, frame in enumerate(subject.frames()):
        picture = captured(frame.stored, case.size_px).picture
        if picture is None or number % EVERY:
            continue
        mask, colours = optics.removal.remove(optics.view.reduce(picture), colours)
        grey = np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY), np.uint8)
        found: list[tuple[Array, Array, float]] = []
        for range_m, bearing_rad in np.concatenate([scan.bases(grey, sector) for sector in range(SECTORS)]):
            start = optics.fitter.search(grey, range_m - body.body_radius_m, bearing_rad)
            fit = None if start is None else optics.fitter.fit(grey, start)
            if fit is None:
                continue
            seen = looks(fit, grey, mask, body, optics.view, optics.projection)
            if seen[0] >= LEAST_SHOWN:
                found.append((fit.centre_m, seen, robot_evidence(fit, grey, mask, body, optics.view, optics.projection)))
        yield frame.stored.stamp_ns, found


if __name__ == "__main__":
    sys.exit(main())
