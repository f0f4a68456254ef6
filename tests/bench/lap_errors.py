"""What an agent and the pose graph make of laps: the same local maps, once with what they tell of places recognised and once without."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass
from itertools import takewhile

import numpy as np

from mapserver.mapping.poses.pose_graph import PoseGraph
from mapserver.mapping.poses.track import Start
from protocol.geometry import Pose2
from protocol.messages import LocalMap, Revisit
from sim.world.scene import FloorKind
from tests.bench.lap_agent import LapAgent
from tests.bench.lap_world import ROBOT, lap_frames, lap_scenario, start
from tests.bench.statistics import Stopwatch

METHODS = ("without", "with")
FLOORS: tuple[FloorKind, ...] = ("paint", "wood", "grid", "concrete")
HEADER = """| floor | landmarks | mean error of each lap [mm] | heading [mrad] | recognised, worst [mm] | ms a frame |
|---|---|---|---|---|---|"""


@dataclass(frozen=True)
class LapErrors:
    """One floor."""

    errors_mm: dict[str, list[float]]  # by method, the mean of every lap
    headings_mrad: dict[str, list[float]]
    misses_mm: list[float]  # of every place recognised: how far it tells the robot from where it is
    landmarks_ms: list[float]  # of every frame


def lap_errors(floor: FloorKind, laps: int, seed: int) -> LapErrors:
    """Drive laps on a floor."""
    scenario, watch = lap_scenario(floor, seed), Stopwatch()
    agent = LapAgent(scenario, watch)
    graphs = {method: PoseGraph({ROBOT: Start(start())}) for method in METHODS}
    truth: dict[int, Pose2] = {}
    errors: dict[str, dict[int, list[tuple[float, float]]]] = {method: defaultdict(list) for method in METHODS}
    misses_mm: list[float] = []
    for frame in takewhile(lambda frame: frame.lap < laps, lap_frames(scenario)):
        truth[frame.stamp_ns] = frame.arena_from_body
        seen = agent.step(frame)
        misses_mm += [_missed(truth, revisit, frame.stamp_ns)[0] for revisit in seen.revisits]
        for method, graph in graphs.items():
            errors[method][frame.lap].append(_off(frame.arena_from_body, _solved(graph, seen, has_landmarks=method == "with")))
    means = {method: [np.mean(each, axis=0).tolist() for each in by_lap.values()] for method, by_lap in errors.items()}
    return LapErrors(
        {method: [mm for mm, _ in each] for method, each in means.items()},
        {method: [mrad for _, mrad in each] for method, each in means.items()},
        misses_mm,
        watch.ms["landmarks"],
    )


def markdown_rows(floor: FloorKind, found: LapErrors) -> str:
    """Return two rows of the table that HEADER begins."""
    told = f"{len(found.misses_mm)}, {max(found.misses_mm, default=0.0):.2f} | {np.mean(found.landmarks_ms):.2f}"
    return "\n".join(
        f"| {floor} | {method} | {_numbers(found.errors_mm[method])} | {_numbers(found.headings_mrad[method])} | {beside} |"
        for method, beside in zip(METHODS, ("- | -", told), strict=True)
    )


def _numbers(values: list[float]) -> str:
    return ", ".join(f"{value:.2f}" for value in values)


def _solved(graph: PoseGraph, seen: LocalMap, *, has_landmarks: bool) -> Pose2:
    """Return where a graph believes the robot to be after one more local map."""
    graph.add(seen if has_landmarks else seen.model_copy(update={"revisits": ()}))
    return graph.update()[ROBOT].arena_from_body


def _missed(truth: dict[int, Pose2], revisit: Revisit, stamp_ns: int) -> tuple[float, float]:
    return _off(truth[revisit.stamp_ns].between(truth[stamp_ns]), Pose2(*revisit.then_from_body))


def _off(true: Pose2, found: Pose2) -> tuple[float, float]:
    """Return by how much a pose is off [mm, mrad]."""
    error = true.between(found)
    return 1e3 * float(np.hypot(error.x_m, error.y_m)), 1e3 * abs(error.theta_rad)
