"""`python -m tests.bench.sightings RECORDING...`: how many of the robots that the agents tell of are robots, as a table of Markdown."""

from __future__ import annotations

import sys
from collections import Counter
from pathlib import Path

import numpy as np

from agent.drivers.bus_camera import captured
from agent.methods import make_pipeline
from protocol.stage_clock import StageClock
from tests.bench.frames import Case, Subject, open_case
from tests.bench.on_recordings import print_table
from tests.bench.true_robots import TrueRobots, stands_there

NEAR_M = 1.0  # farther out a robot is a few pixels wide


def main() -> int:
    """Run the agents on each recording, print a row for it, and return the exit code."""
    return print_table(
        "sightings", __doc__, "| recording | sightings of robots | of other things | robots within a metre that were seen |", _row
    )


def _row(recording: Path) -> str:
    case = open_case(recording)
    truth = TrueRobots(recording, (subject.name for subject in case.subjects))
    counts = sum((_counts(case, subject, truth) for subject in case.subjects), Counter[str]())
    return f"| {case.name} | {counts['right']} | {counts['wrong']} | {counts['seen'] / max(counts['near'], 1):.1%} |"


def _counts(case: Case, subject: Subject, truth: TrueRobots) -> Counter[str]:
    """Return how many of one robot's sightings are right and wrong, how often a robot was near, and how often such a one was seen."""
    agent = make_pipeline(subject.name, 0, "full", subject.body, subject.calibration, StageClock())
    counts: Counter[str] = Counter()
    for frame in subject.frames():
        picture = captured(frame.stored, case.size_px).picture
        told = agent.step(frame.stored.stamp_ns, picture, frame.wheels).local_map.sightings
        robots_m = truth.others_m(subject.name, frame.stored.stamp_ns)
        places_m = [each.range_m * np.array([np.cos(each.bearing_rad), np.sin(each.bearing_rad)]) for each in told]
        right = sum(stands_there(robots_m, place_m) for place_m in places_m)
        near_m = robots_m[np.hypot(*robots_m.T) < NEAR_M]
        seen = sum(stands_there(np.array(places_m).reshape(-1, 2), robot_m) for robot_m in near_m)
        counts.update(right=right, wrong=len(told) - right, near=len(near_m), seen=seen)
    return counts


if __name__ == "__main__":
    sys.exit(main())
