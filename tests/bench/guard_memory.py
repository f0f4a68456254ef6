"""`python -m tests.bench.guard_memory RECORDING...`: what local guards take to stand beside their robots, against what does; a table."""

from __future__ import annotations

import sys
from collections import Counter
from pathlib import Path

import numpy as np
import shapely
from numpy.typing import NDArray

from agent.control.near_things import NearThings
from agent.drivers.bus_camera import captured
from agent.methods import make_pipeline
from deploy.evaluation.truth import Truth, read_truth
from protocol.geometry import Array, Pose2
from protocol.stage_clock import StageClock
from tests.bench.frames import Case, Subject, open_case
from tests.bench.on_recordings import print_table
from tests.bench.true_robots import TrueRobots

BESIDE_M = 0.025  # from the body's edge: what is taken to stand so near may hold the robot up
NOTHING_M = 0.03  # from all that is true: there nothing stands
CLOSE_M, KNOWN_M = 0.05, 0.02  # a thing so near to the body's edge has to be known, and so exactly
_HEADER = "| recording | pictures | something beside it that is not there | a thing close by | not known |"


def main() -> int:
    """Run agents and guards on each recording, print a row for it, and return the exit code."""
    return print_table("guard_memory", __doc__, _HEADER, _row)


def _row(recording: Path) -> str:
    case, truth = open_case(recording), read_truth(recording)
    robots = TrueRobots(recording, truth.trajectories)
    counts = sum((_counts(case, subject, truth, robots) for subject in case.subjects), Counter[str]())
    return f"| {case.name} | {case.count()} | {counts['phantom']} | {counts['close']} | {counts['unknown']} |"


def _counts(case: Case, subject: Subject, truth: Truth, true_robots: TrueRobots) -> Counter[str]:
    """Return in how many of one robot's pictures a phantom stood beside it, a thing was close, and that was not known."""
    agent = make_pipeline(subject.name, 0, "full", subject.body, subject.calibration, StageClock())
    near = NearThings(subject.body.body_radius_m)
    things = shapely.union_all([truth.arena_bounds.exterior, *(obstacle.footprint for obstacle in truth.obstacles)])
    counts: Counter[str] = Counter()
    for frame in subject.frames():
        stamp_ns = frame.stored.stamp_ns
        local_map = agent.step(stamp_ns, captured(frame.stored, case.size_px).picture, frame.wheels).local_map
        places = {name: true_robots.pose(name, stamp_ns) for name in truth.trajectories}
        odom_from_body, arena_from_body = Pose2(*local_map.odom_from_body), places[subject.name]
        odom_from_arena = odom_from_body @ arena_from_body.inverse()
        near.see(local_map)
        near.note_robots(stamp_ns, subject.name, {name: odom_from_arena.apply(place[:2]) for name, place in places.items()})
        del places[subject.name]
        known = near.around(odom_from_body).points_m
        beside = known[np.hypot(*known.T) < subject.body.body_radius_m + BESIDE_M]
        robots = shapely.union_all([shapely.Point(place[:2]).buffer(truth.body_radius_m[name]) for name, place in places.items()])
        counts["phantom"] += bool((_off_m(arena_from_body.apply(beside), shapely.union(things, robots)) > NOTHING_M).any())
        nearest_m = np.array(shapely.shortest_line(shapely.Point(arena_from_body[:2]), things).coords[1])
        is_close = np.hypot(*(nearest_m - arena_from_body[:2])) < subject.body.body_radius_m + CLOSE_M
        is_known = np.hypot(*(known - arena_from_body.inverse().apply(nearest_m)).T).min(initial=np.inf) < KNOWN_M
        counts.update(close=int(is_close), unknown=int(is_close and not is_known))
    return counts


def _off_m(points_m: Array, things: shapely.Geometry) -> Array:
    """Return how far points, (n, 2), are from all things, (n,)."""
    points: NDArray[np.object_] = shapely.points(points_m)
    return np.asarray(shapely.distance(points, things), dtype=np.float64)


if __name__ == "__main__":
    sys.exit(main())
