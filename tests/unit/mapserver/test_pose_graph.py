"""The pose graph: odometry, robots that see each other, and everything that goes wrong on the way."""

from __future__ import annotations

import math

import numpy as np
import pytest

from mapserver.mapping.belief import Belief
from mapserver.mapping.poses.association import associate
from mapserver.mapping.poses.pose_graph import PoseGraph
from mapserver.mapping.poses.sighting_noise import SightingLedger, added_information, model_error
from mapserver.mapping.poses.track import Start
from protocol.geometry import Pose2
from protocol.messages import Identity, LocalMap, Sighting
from tests.unit.mapserver.worlds import MOTION_SIGMA, STEP_NS, Swarm, local_map, sighting_of

STARTS = {"r1": Pose2(0.0, 0.0, 0.0), "r2": Pose2(-0.5, 0.4, 0.0), "r3": Pose2(-0.5, -0.4, 0.1)}
LOOSE = (0.01, 0.01, math.radians(1.0))
SIGMAS = {"r1": (0.0, 0.0, 0.0), "r2": LOOSE, "r3": LOOSE}
ARC = {robot: Pose2(0.03, 0.0, 0.02) for robot in STARTS}


def feed(graph: PoseGraph, local_maps: list[LocalMap]) -> dict[str, Belief]:
    for each in local_maps:
        graph.add(each)
    for each in local_maps:
        beliefs = {robot: graph.belief(robot, each.stamp_ns) for robot in STARTS}
        observer = beliefs.pop(each.robot)
        for match in associate(each.sightings, observer, beliefs):
            graph.see(each, match.robot, match.sighting)
    return graph.update()


def error_of(belief: Belief, truth: Pose2) -> tuple[float, float]:
    """Return the error of position [m] and heading [rad]."""
    off = truth.between(belief.arena_from_body)
    return math.hypot(off.x_m, off.y_m), abs(off.theta_rad)


def test_odometry_alone_chains_motions_from_the_start() -> None:
    graph = PoseGraph({"r1": Start(Pose2(1.0, 2.0, math.pi / 2))})
    graph.add(local_map("r1", 0))
    graph.add(local_map("r1", 1, motion=Pose2(0.1, 0.0, 0.0)))
    assert np.allclose(graph.update()["r1"].arena_from_body, (1.0, 2.1, math.pi / 2), atol=1e-9)


def test_a_start_of_sigma_nought_is_known_to_a_tenth_of_a_millimetre() -> None:
    graph = PoseGraph({"r1": Start(Pose2.identity())})
    graph.add(local_map("r1", 0))
    assert np.allclose(np.sqrt(np.diag(graph.update()["r1"].covariance)), 1e-4, rtol=0.2)


def test_a_robot_whose_start_is_known_roughly_is_searched_for_until_others_have_seen_it() -> None:
    swarm = Swarm(STARTS, SIGMAS | {"r3": (0.05, 0.05, math.radians(5.0))}, seed=1)
    graph = PoseGraph(swarm.starts)
    graph.add(local_map("r3", 0))
    assert graph.is_searching("r3")
    graph = PoseGraph(swarm.starts)
    feed(graph, swarm.drive())
    for _ in range(20):
        feed(graph, swarm.drive(ARC))
    assert not any(graph.is_searching(robot) for robot in STARTS)


@pytest.mark.parametrize("seed", range(5))
def test_wrong_starts_are_corrected_by_seeing_each_other(seed: int) -> None:
    swarm = Swarm(STARTS, SIGMAS, seed)
    graph = PoseGraph(swarm.starts)
    beliefs = feed(graph, swarm.drive())
    for _ in range(30):
        beliefs = feed(graph, swarm.drive(ARC))
    for robot in ("r2", "r3"):
        position_m, heading_rad = error_of(beliefs[robot], swarm.poses[robot])
        assert position_m < 0.008
        assert heading_rad < math.radians(0.6)


def test_without_sightings_a_wrong_start_stays_wrong() -> None:
    swarm = Swarm(STARTS, SIGMAS)
    graph = PoseGraph(swarm.starts)
    beliefs = feed(graph, swarm.drive(blind=True))
    assert error_of(beliefs["r2"], swarm.poses["r2"])[0] == pytest.approx(math.hypot(0.01, 0.01), rel=1e-3)


@pytest.mark.parametrize("seed", range(5))
def test_a_start_wrong_by_five_centimetres_and_degrees_is_found(seed: int) -> None:
    rough = (0.05, 0.05, math.radians(5.0))
    swarm = Swarm(STARTS, {"r1": (0.0, 0.0, 0.0), "r2": rough, "r3": rough}, seed)
    graph = PoseGraph(swarm.starts)
    beliefs = feed(graph, swarm.drive())
    for _ in range(10):
        beliefs = feed(graph, swarm.drive(ARC))
    assert max(error_of(beliefs[robot], swarm.poses[robot])[0] for robot in ("r2", "r3")) < 0.012


def test_a_false_sighting_moves_nobody() -> None:
    swarm = Swarm(STARTS, SIGMAS)
    graph = PoseGraph(swarm.starts)
    feed(graph, swarm.drive())
    for step in range(20):
        wrong = sighting_of(swarm.poses["r1"], swarm.poses["r2"], Identity(kind="robot", name="r2"), error_m=(0.3, -0.2))
        beliefs = feed(graph, swarm.drive(ARC, false_sightings=[wrong] if step % 5 == 4 else []))
    assert error_of(beliefs["r2"], swarm.poses["r2"])[0] < 0.01
    assert error_of(beliefs["r1"], swarm.poses["r1"])[0] < 0.01


def test_the_covariance_is_honest() -> None:
    """The normalised error of the pose, over many runs, is about that of three degrees of freedom."""
    squared = []
    for seed in range(40):
        swarm = Swarm(STARTS, SIGMAS, seed)
        graph = PoseGraph(swarm.starts)
        feed(graph, swarm.drive())
        for _ in range(8):
            beliefs = feed(graph, swarm.drive(ARC))
        off = swarm.poses["r2"].between(beliefs["r2"].arena_from_body).log()
        squared.append(off @ np.linalg.solve(beliefs["r2"].covariance, off))
    assert np.mean(squared) < 6.0


def test_a_lost_local_map_is_bridged_by_the_odometry() -> None:
    graph = PoseGraph({"r1": Start(Pose2.identity())})
    graph.add(local_map("r1", 0))
    graph.add(local_map("r1", 3, motion=Pose2(0.1, 0.0, 0.0), odom=Pose2(0.3, 0.0, 0.0)))
    belief = graph.update()["r1"]
    assert belief.arena_from_body.x_m == pytest.approx(0.3, abs=1e-9)
    assert belief.covariance[0, 0] > 2.5 * MOTION_SIGMA[0] ** 2


def test_a_restarted_agent_goes_on_where_its_robot_was_believed_to_be() -> None:
    graph = PoseGraph({"r1": Start(Pose2.identity())})
    graph.add(local_map("r1", 0))
    graph.add(local_map("r1", 1, motion=Pose2(0.1, 0.0, 0.0), odom=Pose2(0.1, 0.0, 0.0)))
    graph.update()
    graph.add(local_map("r1", 0, epoch=1, stamp_ns=10 * STEP_NS))
    belief = graph.update()["r1"]
    assert belief.arena_from_body.x_m == pytest.approx(0.1, abs=1e-6)
    assert belief.covariance[0, 0] > 0.05**2


def test_a_silent_robot_is_carried_on_and_grows_uncertain() -> None:
    graph = PoseGraph({"r1": Start(Pose2.identity())})
    graph.add(local_map("r1", 0))
    graph.add(local_map("r1", 1, motion=Pose2(0.02, 0.0, 0.0)))
    now = graph.update()["r1"]
    soon, later, much_later = (graph.belief("r1", 2 * STEP_NS + elapsed) for elapsed in (STEP_NS, 5 * STEP_NS, 50 * STEP_NS))
    assert soon.arena_from_body.x_m == pytest.approx(0.04, abs=1e-6)
    assert later.arena_from_body.x_m == pytest.approx(0.12, abs=1e-6)
    assert much_later.arena_from_body.x_m == pytest.approx(0.12, abs=1e-6)
    assert [b.predicted for b in (now, soon, later)] == [False, True, True]
    traces = [float(np.trace(b.covariance)) for b in (now, soon, later, much_later)]
    assert traces == sorted(traces)
    assert traces[-1] > 1.0


def test_a_robot_never_heard_of_is_predicted_at_its_start() -> None:
    graph = PoseGraph({"r1": Start(Pose2(1.0, 0.0, 0.0))})
    belief = graph.belief("r1", STEP_NS)
    assert belief.predicted
    assert belief.arena_from_body == Pose2(1.0, 0.0, 0.0)


def test_the_trajectory_has_one_pose_for_every_local_map() -> None:
    swarm = Swarm(STARTS, SIGMAS)
    graph = PoseGraph(swarm.starts)
    for _ in range(4):
        feed(graph, swarm.drive(ARC))
    stamps_ns, poses = graph.trajectory("r2")
    assert stamps_ns.tolist() == [STEP_NS * number for number in (1, 2, 3, 4)]
    assert np.allclose(poses[-1], graph.belief("r2", 4 * STEP_NS).arena_from_body)


def test_two_still_robots_do_not_grow_certain_without_bound() -> None:
    ledger = SightingLedger()
    observer, target = Pose2.identity(), Pose2(0.8, 0.0, 0.0)
    seen = sighting_of(observer, target)
    information = np.zeros((2, 2))
    for _ in range(1000):
        covariance = ledger.covariance(("r1", "r2"), observer, target, seen)
        information += 0.0 if covariance is None else np.linalg.inv(covariance)
    assert (np.linalg.eigvalsh(np.linalg.inv(model_error(seen.range_m)) - information) > 0.0).all()


def test_a_pair_that_has_driven_on_counts_in_full_again() -> None:
    ledger = SightingLedger()
    seen = sighting_of(Pose2.identity(), Pose2(0.8, 0.0, 0.0))
    first = ledger.covariance(("r1", "r2"), Pose2.identity(), Pose2(0.8, 0.0, 0.0), seen)
    second = ledger.covariance(("r1", "r2"), Pose2.identity(), Pose2(0.8, 0.0, 0.0), seen)
    moved = ledger.covariance(("r1", "r2"), Pose2(0.06, 0.0, 0.0), Pose2(0.86, 0.0, 0.0), seen)
    assert first is not None
    assert moved is not None
    assert second is None or np.trace(second) > 2.0 * np.trace(first)
    assert np.allclose(moved, first)


def test_added_information_sums_to_that_of_the_mean() -> None:
    repeated, white = np.diag([4.0, 1.0]), np.diag([9.0, 2.0])
    total = sum(added_information(count, repeated, white) for count in range(1, 11))
    assert np.allclose(np.linalg.inv(total), repeated + white / 10)


def belief_at(x_m: float, y_m: float, sigma_m: float = 0.001) -> Belief:
    return Belief(Pose2(x_m, y_m, 0.0), np.eye(3) * sigma_m**2)


def anonymous(x_m: float, y_m: float) -> Sighting:
    return sighting_of(Pose2.identity(), Pose2(x_m, y_m, 0.0))


def test_an_anonymous_sighting_near_a_robot_is_that_robot() -> None:
    matches = associate([anonymous(1.05, 0.0), anonymous(0.0, 2.0)], belief_at(0.0, 0.0), {"r2": belief_at(1.0, 0.0)})
    assert [(match.robot, round(match.sighting.range_m, 2)) for match in matches] == [("r2", 1.05)]


def test_of_two_sightings_the_nearer_one_is_the_robot() -> None:
    matches = associate([anonymous(1.08, 0.0), anonymous(1.01, 0.0)], belief_at(0.0, 0.0), {"r2": belief_at(1.0, 0.0)})
    assert [match.sighting.range_m for match in matches] == [pytest.approx(1.01)]


def test_each_robot_takes_its_own_sighting() -> None:
    others = {"r2": belief_at(1.0, 0.0), "r3": belief_at(1.1, 0.0)}
    matches = associate([anonymous(1.09, 0.0), anonymous(1.02, 0.0)], belief_at(0.0, 0.0), others)
    assert {match.robot: round(match.sighting.range_m, 2) for match in matches} == {"r2": 1.02, "r3": 1.09}


def test_the_gate_opens_with_uncertainty_but_never_beyond_its_limit() -> None:
    far = anonymous(1.25, 0.0)
    assert associate([far], belief_at(0.0, 0.0), {"r2": belief_at(1.0, 0.0)}) == []
    assert len(associate([far], belief_at(0.0, 0.0), {"r2": belief_at(1.0, 0.0, sigma_m=0.1)})) == 1
    assert associate([anonymous(1.5, 0.0)], belief_at(0.0, 0.0), {"r2": belief_at(1.0, 0.0, sigma_m=1.0)}) == []


def test_named_robots_are_taken_at_their_word_and_strangers_left_out() -> None:
    named = sighting_of(Pose2.identity(), Pose2(3.0, 0.0, 0.0), Identity(kind="robot", name="r2"))
    stranger = sighting_of(Pose2.identity(), Pose2(1.0, 0.0, 0.0), Identity(kind="robot", name="r9"))
    landmark = sighting_of(Pose2.identity(), Pose2(1.0, 0.0, 0.0), Identity(kind="landmark", name="7"))
    matches = associate([named, stranger, landmark], belief_at(0.0, 0.0), {"r2": belief_at(1.0, 0.0)})
    assert [match.robot for match in matches] == ["r2"]


def test_a_nonsensical_covariance_does_not_break_the_graph() -> None:
    swarm = Swarm(STARTS, SIGMAS)
    graph = PoseGraph(swarm.starts)
    feed(graph, swarm.drive())
    maps = [
        each.model_copy(
            update={
                "motion_covariance": (-1.0, 1e300, 0.0, 0.0, -1e300, 0.0),
                "sightings": tuple(s.model_copy(update={"covariance": (-1.0, 5.0, 1e300)}) for s in each.sightings),
            }
        )
        for each in swarm.drive(ARC)
    ]
    beliefs = feed(graph, maps)
    assert all(np.isfinite(belief.arena_from_body).all() and np.isfinite(belief.covariance).all() for belief in beliefs.values())
