"""What the pose graph's update costs beside bare iSAM2 with the same factors, step by step side by side, on a graph of 3,500 poses.

The graph is of the kind of the UTIAS sets (Leung et al., IJRR 2011): five robots, each steered at random in a room with fifteen landmarks,
which sight landmarks and each other. Bare iSAM2 is GTSAM's with its own defaults, which is given the same factors and first values, solves
once a step, and is asked for the same poses and covariances.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import gtsam
import numpy as np

from mapserver.mapping.belief import Belief
from mapserver.mapping.poses.pose_graph import PoseGraph
from mapserver.mapping.poses.solver import Effort, Solver
from mapserver.mapping.poses.track import Start
from protocol.geometry import Array, Pose2
from protocol.messages import Identity, LocalMap, Sighting
from tests.bench.statistics import Ratio, Stopwatch, Times, ratio_of_medians, times
from tests.unit.mapserver.worlds import MOTION_SIGMA, local_map, sighting_of

ROBOTS, POSES = 5, 3500
LANDMARKS = 15
ROOM_M = 6.0
SIGHT_M = 3.0
SIGHTINGS_A_STEP = 2  # of landmarks, and of robots, at most
OWN, BARE = "graph update", "bare iSAM2"


class GraphContest(NamedTuple):
    """Times of a step, and how the sums over all steps compare."""

    own: Times
    bare: Times
    ratio_of_sums: float
    ratio_of_medians: Ratio


class _Witness(Solver):
    """Solves as always, and keeps what it was given and asked last, for another to be given and asked the same."""

    def update(self, factors: gtsam.NonlinearFactorGraph, values: gtsam.Values) -> None:
        self.last: tuple[gtsam.NonlinearFactorGraph, gtsam.Values] = factors, values
        self.asked: list[int] = []
        super().update(factors, values)

    def belief(self, key: int) -> Belief:
        self.asked.append(key)
        return super().belief(key)


def measure_graph(poses: int = POSES, effort: Effort | None = None, seed: int = 1) -> GraphContest:
    """Let both take the same steps until the graph has so many poses."""
    world, witness, bare, stopwatch = _World(seed), _Witness(effort), gtsam.ISAM2(gtsam.ISAM2Params()), Stopwatch()
    graph = PoseGraph({robot: Start(pose) for robot, pose in world.poses.items()}, witness)
    for _ in range(poses // ROBOTS):
        local_maps = world.step()
        for each in local_maps:
            graph.add(each)
        for each in local_maps:
            _tie(graph, each)
        with stopwatch.stage(OWN):
            graph.update()
        with stopwatch.stage(BARE):
            bare.update(*witness.last)
            for key in witness.asked:
                bare.calculateEstimatePose2(key)
                bare.marginalCovariance(key)
    own_ms, bare_ms = stopwatch.ms[OWN], stopwatch.ms[BARE]
    return GraphContest(times(own_ms), times(bare_ms), sum(own_ms) / sum(bare_ms), ratio_of_medians(own_ms, bare_ms))


def _tie(graph: PoseGraph, each: LocalMap) -> None:
    for sighting in each.sightings:
        if sighting.identity.kind == "landmark":
            graph.see_landmark(each, sighting)
        else:
            graph.see(each, sighting.identity.name, sighting)


class _World:
    """Robots at their true poses, and the landmarks."""

    def __init__(self, seed: int) -> None:
        self._random = np.random.default_rng(seed)
        starts_m = self._random.uniform(-2.0, 2.0, (ROBOTS, 2)).tolist()
        self.poses = {f"r{number + 1}": Pose2(x_m, y_m, 0.0) for number, (x_m, y_m) in enumerate(starts_m)}
        self._landmarks_m = self._random.uniform(-0.5 * ROOM_M, 0.5 * ROOM_M, (LANDMARKS, 2))
        self._seq = -1

    def step(self) -> list[LocalMap]:
        """Move all robots (not at the first call) and return their local maps, in the order of their names."""
        self._seq += 1
        measured = {robot: self._move(robot) for robot in self.poses}
        return [local_map(robot, self._seq, motion=motion, sightings=self._sightings(robot)) for robot, motion in measured.items()]

    def _move(self, robot: str) -> Pose2:
        if self._seq == 0:
            return Pose2.identity()
        pose = self.poses[robot]
        homeward_rad: float = math.atan2(-pose.y_m, -pose.x_m) - pose.theta_rad
        turn_rad = 0.3 * math.sin(homeward_rad) if math.hypot(pose.x_m, pose.y_m) > 0.4 * ROOM_M else self._random.normal(0.0, 0.2)
        motion = Pose2.exp((0.12, 0.0, turn_rad))
        self.poses[robot] = pose @ motion
        return motion @ Pose2.exp(self._random.normal(0.0, MOTION_SIGMA))

    def _sightings(self, robot: str) -> list[Sighting]:
        own = self.poses[robot]
        landmarks = [
            (Pose2(x_m, y_m, 0.0), Identity(kind="landmark", name=str(number)))
            for number, (x_m, y_m) in enumerate(self._landmarks_m.tolist())
        ]
        others = [(pose, Identity(kind="robot", name=name)) for name, pose in self.poses.items() if name != robot]
        return [
            sighting_of(own, place, identity, self._error_m())
            for things in (landmarks, others)
            for place, identity in [each for each in things if math.dist(each[0][:2], own[:2]) < SIGHT_M][:SIGHTINGS_A_STEP]
        ]

    def _error_m(self) -> tuple[float, float]:
        error: Array = self._random.normal(0.0, 2e-3, 2)
        return float(error[0]), float(error[1])
