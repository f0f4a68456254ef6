"""A robot without a place keeps its path to itself, until it is placed."""

from __future__ import annotations

import numpy as np
import pytest

from mapserver.mapping.belief import Belief
from mapserver.mapping.poses.odometry import MOST_LINKS, Chain
from mapserver.mapping.poses.pose_graph import PoseGraph
from mapserver.mapping.poses.track import Start
from protocol.geometry import Pose2
from tests.unit.mapserver.worlds import STEP_NS, local_map, sighting_of

AHEAD = Pose2(0.1, 0.0, 0.2)
R2_START = Pose2(1.0, 0.5, 2.0)
LOOSE = np.diag([0.01, 0.01, 0.01])


def graph_of_two(steps: int) -> PoseGraph:
    graph = PoseGraph({"r1": Start(Pose2.identity()), "r2": None})
    odom = Pose2.identity()
    for seq in range(steps):
        odom = odom @ AHEAD if seq else odom
        graph.add(local_map("r1", seq))
        graph.add(local_map("r2", seq, motion=AHEAD, odom=odom))
    return graph


def pose_after(steps: int) -> Pose2:
    pose = R2_START
    for _ in range(steps - 1):
        pose = pose @ AHEAD
    return pose


def test_a_robot_without_a_place_has_no_pose_and_ties_nothing() -> None:
    graph = graph_of_two(3)
    seen = local_map("r1", 2)
    graph.see(seen, "r2", sighting_of(Pose2.identity(), pose_after(3)))
    graph.see(local_map("r2", 2), "r1", sighting_of(pose_after(3), Pose2.identity()))
    assert list(graph.update()) == list(graph.beliefs(3 * STEP_NS)) == ["r1"]
    assert not graph.has_place("r2")
    assert not graph.is_placed("r2")
    assert len(graph.trajectory("r2")[0]) == 0


def test_a_placed_robot_brings_its_whole_path_along() -> None:
    graph = graph_of_two(5)
    graph.place("r2", 3 * STEP_NS, Belief(pose_after(3), LOOSE))
    belief = graph.update()["r2"]
    assert graph.is_placed("r2")
    assert belief.arena_from_body == pytest.approx(pose_after(5), abs=1e-9)
    assert (np.diag(belief.covariance) > 0.009).all()
    stamps_ns, poses = graph.trajectory("r2")
    assert stamps_ns.tolist() == [STEP_NS * number for number in range(1, 6)]
    assert poses[0] == pytest.approx(R2_START, abs=1e-9)


def test_sightings_from_before_refine_where_a_robot_was_placed() -> None:
    graph = graph_of_two(5)
    off = Pose2(0.05, -0.05, 0.05)
    graph.place("r2", 5 * STEP_NS, Belief(pose_after(5) @ off, LOOSE))
    for seq in range(5):
        graph.see(local_map("r1", seq), "r2", sighting_of(Pose2.identity(), pose_after(seq + 1)))
        graph.see(local_map("r2", seq), "r1", sighting_of(pose_after(seq + 1), Pose2.identity()))
    belief = graph.update()["r2"]
    assert belief.arena_from_body == pytest.approx(pose_after(5), abs=2e-3)
    assert (np.diag(belief.covariance) < 1e-4).all()


def test_a_placed_robot_drives_on_in_the_graph() -> None:
    graph = graph_of_two(3)
    graph.place("r2", 3 * STEP_NS, Belief(pose_after(3), LOOSE))
    graph.update()
    graph.add(local_map("r2", 3, motion=AHEAD))
    assert graph.update()["r2"].arena_from_body == pytest.approx(pose_after(4), abs=1e-9)


def test_what_a_robot_drove_before_its_agent_restarted_is_not_joined_to_what_it_drives_after() -> None:
    graph = graph_of_two(3)
    graph.add(local_map("r2", 0, epoch=1, stamp_ns=10 * STEP_NS))
    graph.add(local_map("r2", 1, epoch=1, stamp_ns=11 * STEP_NS, motion=AHEAD))
    graph.place("r2", 11 * STEP_NS, Belief(R2_START, LOOSE))
    graph.update()
    assert graph.trajectory("r2")[0].tolist() == [10 * STEP_NS, 11 * STEP_NS]


def test_a_chain_is_remembered_for_so_long_only() -> None:
    chain = Chain()
    for seq in range(MOST_LINKS + 3):
        chain.add(local_map("r2", seq, motion=Pose2(1e-3, 0.0, 0.0)))
    assert len(chain.stamps_ns) == len(chain.start_from_body) == len(chain.twists) == MOST_LINKS
    assert chain.pose(chain.stamps_ns[-1]).x_m == pytest.approx(1e-3 * (MOST_LINKS + 2))
