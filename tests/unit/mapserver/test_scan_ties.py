"""What stands ties paths: robots that never see each other agree by what both see, and drift stays bounded; what is wrong ties nothing."""

from __future__ import annotations

import math

import numpy as np
import pytest

from mapserver.mapping.belief import Belief
from mapserver.mapping.poses.pose_graph import Extent, PoseGraph
from mapserver.mapping.poses.scan import Standing
from mapserver.mapping.poses.scan_ties import MOST_REFERENCES, ScanTies
from mapserver.mapping.poses.solver import Solver
from mapserver.mapping.poses.track import Start
from mapserver.pipeline import MapPipeline
from protocol.fields import covariance_tuple
from protocol.geometry import Array, Pose2
from protocol.messages import LocalMap
from protocol.stage_clock import StageClock
from tests.unit.mapserver.test_scan import HEIGHT_M, mapped
from tests.unit.mapserver.worlds import batch, local_map, rectangle, region_of, settings, smear_of

BOXES = tuple(rectangle(x_m, y_m, 0.2, 0.2) for x_m, y_m in ((0.0, 0.0), (1.1, 0.2), (-0.2, 1.1), (-1.1, 0.1), (0.1, -1.1)))
STARTS = {"r1": Pose2(0.6, 0.0, math.pi / 2), "r2": Pose2(-0.6, 0.0, -math.pi / 2)}
SIGMA = np.array([1e-3, 1e-3, 3e-3])  # of every step that is told [m, m, rad]
LAP = 24
STEP = Pose2.exp((2.0 * math.pi * 0.6 / LAP, 0.0, 2.0 * math.pi / LAP))


class Drive:
    """Two robots on one circle, which never see each other, and measure their motion with noise."""

    def __init__(self) -> None:
        self.poses = dict(STARTS)
        self._random = np.random.default_rng(1)
        self._seq = -1

    def step(self, boxes: tuple[Array, ...] = BOXES) -> list[LocalMap]:
        """Drive on (not at the first call), and return what the robots tell."""
        self._seq += 1
        if self._seq:
            self.poses = {robot: pose @ STEP for robot, pose in self.poses.items()}
        return [self._told(robot, boxes) for robot in STARTS]

    def apart_m(self, places: dict[str, Pose2]) -> float:
        """Return how wrong the robots' places are to each other."""
        true, told = (each["r1"].between(each["r2"]) for each in (self.poses, places))
        return math.dist(true[:2], told[:2])

    def _told(self, robot: str, boxes: tuple[Array, ...]) -> LocalMap:
        pose, measured = self.poses[robot], STEP @ Pose2.exp(self._random.normal(0.0, SIGMA))
        regions = [region_of(smear_of(box, HEIGHT_M, pose), pose, height_m=HEIGHT_M) for box in boxes]
        told = local_map(robot, self._seq, motion=measured if self._seq else None, regions=regions)
        return told.model_copy(update={"motion_covariance": covariance_tuple(np.diag(SIGMA**2))})


class Tied:
    """The same drive, the graph and the scans alone, the boxes being known to stand."""

    def __init__(self, extent: Extent | None = None) -> None:
        self.drive = Drive()
        self.graph = PoseGraph({robot: Start(pose) for robot, pose in STARTS.items()}, Solver(), extent)
        self.ties = ScanTies(self.graph)
        self.beliefs: dict[str, Belief] = {}

    def go(self, steps: int, boxes: tuple[Array, ...] = BOXES, standing: Standing | None = None) -> None:
        """Drive on among boxes, of which those that the map knows are `standing`."""
        known = standing or mapped(*BOXES)
        for _ in range(steps):
            local_maps = self.drive.step(boxes)
            for each in local_maps:
                self.graph.add(each)
                self.ties.tie(each, known, ())
            self.beliefs = self.graph.update()

    def apart_m(self) -> float:
        return self.drive.apart_m({robot: belief.arena_from_body for robot, belief in self.beliefs.items()})

    def worst_m(self) -> float:
        return max(math.dist(self.beliefs[robot].arena_from_body[:2], pose[:2]) for robot, pose in self.drive.poses.items())


def test_robots_that_never_see_each_other_agree_by_the_boxes_that_both_see() -> None:
    tied, blind = Tied(), Tied()
    tied.go(3 * LAP)
    blind.go(3 * LAP, boxes=())
    assert tied.apart_m() < 0.015
    assert blind.apart_m() > 0.03


def test_drift_is_bounded_though_old_poses_leave_the_graph() -> None:
    tied, blind = Tied(Extent(most_poses=60, kept_poses=40)), Tied()
    for _ in range(4):
        tied.go(LAP)
        blind.go(LAP, boxes=())
        assert tied.worst_m() < 0.015
    assert blind.worst_m() > 0.025


def test_a_box_that_was_pushed_ties_nobody_to_a_wrong_place() -> None:
    tied, moved = Tied(), (BOXES[0] + (0.04, 0.03), *BOXES[1:])
    tied.go(LAP)
    tied.go(LAP, moved, mapped(*moved))
    assert tied.worst_m() < 0.015


@pytest.mark.slow
def test_the_whole_map_server_ties_robots_by_what_it_has_mapped() -> None:
    drive, pipeline = Drive(), MapPipeline([settings(robot, pose) for robot, pose in STARTS.items()], StageClock())
    for _ in range(3 * LAP):
        merged = pipeline.step(batch(drive.step()))
    assert drive.apart_m({each.robot: Pose2(*each.arena_from_body) for each in merged.poses.robots}) < 0.015


def test_boxes_that_the_map_does_not_know_tie_nobody() -> None:
    some, none = Tied(), Tied()
    some.go(LAP, BOXES, mapped())
    none.go(LAP, ())
    assert some.worst_m() == pytest.approx(none.worst_m())


def test_who_stands_still_is_tied_once() -> None:
    graph = PoseGraph({"r1": Start(STARTS["r1"])})
    ties, counted = ScanTies(graph), []
    for seq in range(4):
        seen = local_map("r1", seq, regions=[region_of(smear_of(box, HEIGHT_M, STARTS["r1"]), STARTS["r1"]) for box in BOXES])
        graph.add(seen)
        ties.tie(seen, mapped(*BOXES), ())
        counted.append(ties.references)
        graph.update()
    assert counted == [1, 1, 1, 1]


def test_there_are_only_so_many_references() -> None:
    graph = PoseGraph({"r1": Start(Pose2.identity())})
    ties = ScanTies(graph)
    for seq in range(MOST_REFERENCES + 5):
        eye = Pose2(0.5 * seq, 0.0, 0.0)
        around = [rectangle(eye.x_m + x_m, y_m, 0.2, 0.2) for x_m, y_m in ((0.5, 0.1), (-0.2, 0.5))]
        seen = local_map(
            "r1",
            seq,
            motion=Pose2(0.5, 0.0, 0.0) if seq else None,
            regions=[region_of(smear_of(box, HEIGHT_M, eye), eye) for box in around],
        )
        seen = seen.model_copy(update={"motion_covariance": covariance_tuple(np.zeros((3, 3)))})
        graph.add(seen)
        ties.tie(seen, mapped(*around), ())
        graph.update()
    assert ties.references == MOST_REFERENCES
    assert np.isfinite(graph.reference(MOST_REFERENCES - 1)).all()
