"""A pose graph that holds so many poses and no more: old ones leave it, and what they told stays."""

from __future__ import annotations

import math

import numpy as np
import pytest

from mapserver.mapping.poses.pose_graph import Extent, PoseGraph
from mapserver.mapping.poses.solver import Solver
from mapserver.mapping.poses.track import MOST_PAST_POSES, Past
from protocol.geometry import Pose2
from tests.unit.mapserver.test_pose_graph import ARC, SIGMAS, STARTS, error_of, feed
from tests.unit.mapserver.worlds import Swarm

SMALL = Extent(most_poses=90, kept_poses=45)


def driven(extent: Extent | None, steps: int) -> tuple[PoseGraph, Swarm]:
    swarm = Swarm(STARTS, SIGMAS)
    graph = PoseGraph(swarm.starts, Solver(), extent)
    feed(graph, swarm.drive())
    for _ in range(steps):
        feed(graph, swarm.drive(ARC))
    return graph, swarm


def test_poses_are_as_good_and_as_certain_as_those_of_a_graph_that_holds_all() -> None:
    (bounded, swarm), (whole, _) = driven(SMALL, 60), driven(None, 60)
    for robot, truth in swarm.poses.items():
        own, best = bounded.update()[robot], whole.update()[robot]
        assert error_of(own, best.arena_from_body)[0] < 1e-3
        assert error_of(own, truth)[0] < 0.02
        assert np.allclose(np.sqrt(np.diag(own.covariance)), np.sqrt(np.diag(best.covariance)), rtol=0.05)


def test_smoothed_paths_remain_whole() -> None:
    (bounded, _), (whole, _) = driven(SMALL, 60), driven(None, 60)
    for robot in STARTS:
        stamps_ns, poses = bounded.trajectory(robot)
        best_ns, best = whole.trajectory(robot)
        assert stamps_ns.tolist() == best_ns.tolist()
        assert np.hypot(*(poses - best)[:, :2].T).max() < 0.005


def test_what_has_left_the_graph_has_no_pose_any_more_and_ties_nothing() -> None:
    graph, swarm = driven(SMALL, 60)
    first_ns = int(graph.trajectory("r1")[0][0])
    assert graph.pose_at("r1", first_ns) is None
    assert graph.pose("r1", first_ns) is None
    feed(graph, swarm.drive(ARC))


def test_the_newest_pose_of_a_robot_that_has_fallen_silent_stays() -> None:
    swarm = Swarm(STARTS, SIGMAS)
    graph = PoseGraph(swarm.starts, Solver(), SMALL)
    silent_ns = 0
    for number in range(80):
        local_maps = swarm.drive(ARC if number else None)
        feed_some = [each for each in local_maps if each.robot != "r3" or number < 3]
        silent_ns = max(each.stamp_ns for each in feed_some if each.robot == "r3") if number < 3 else silent_ns
        feed(graph, feed_some)
    assert graph.pose_at("r3", silent_ns) is not None


@pytest.mark.parametrize("count", [10, MOST_PAST_POSES + 1, 5 * MOST_PAST_POSES])
def test_a_past_keeps_a_bounded_number_of_poses_in_their_order(count: int) -> None:
    past = Past()
    for stamp_ns in range(count):
        past.add(stamp_ns, Pose2(float(stamp_ns), 0.0, math.pi))
    assert min(count, MOST_PAST_POSES // 2) <= len(past.stamps_ns) <= MOST_PAST_POSES
    assert past.stamps_ns == sorted(past.stamps_ns)
    assert [pose.x_m for pose in past.poses] == past.stamps_ns
