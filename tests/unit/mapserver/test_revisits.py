"""Places that a robot recognises tie its path to itself."""

from __future__ import annotations

import math

import numpy as np

from mapserver.mapping.poses.pose_graph import PoseGraph
from mapserver.mapping.poses.track import Start
from protocol.fields import covariance_tuple, pose_tuple
from protocol.geometry import Pose2
from protocol.messages import LocalMap, Revisit
from tests.unit.mapserver.worlds import STEP_NS, local_map

LAP, LAPS = 20, 4
STEP = Pose2.exp((0.05, 0.0, 2.0 * math.pi / LAP))  # round in a circle
DRIFT = Pose2(0.0, 0.0, 0.0002)  # [m, m, rad] by which every step is told wrong
REVISIT_SIGMA = 2e-4


def stamp_ns(number: int) -> int:
    return (number + 1) * STEP_NS


def revisit(number: int, then_from_body: Pose2, sigma: float = REVISIT_SIGMA) -> Revisit:
    covariance = covariance_tuple(sigma**2 * np.eye(3))
    return Revisit(stamp_ns=stamp_ns(number), then_from_body=pose_tuple(then_from_body), covariance=covariance)


def path(revisits: dict[int, Revisit]) -> list[LocalMap]:
    """Return the local maps of LAPS laps, some of which tell of an earlier place."""
    return [
        local_map("r1", number, motion=STEP @ DRIFT if number else None).model_copy(
            update={"revisits": (revisits[number],) if number in revisits else ()}
        )
        for number in range(LAPS * LAP + 1)
    ]


def driven(revisits: dict[int, Revisit], lost: frozenset[int] = frozenset()) -> PoseGraph:
    graph = PoseGraph({"r1": Start(Pose2.identity())})
    for each in path(revisits):
        if each.seq not in lost:
            graph.add(each)
            graph.update()
    return graph


def off(graph: PoseGraph, number: int = LAPS * LAP) -> Pose2:
    """Return by how much the pose of a frame is off; a whole number of laps leads back to the start."""
    pose = graph.pose_at("r1", stamp_ns(number))
    assert pose is not None
    return Pose2.exp(number * STEP.log()).between(pose)


EVERY_QUARTER = {number: revisit(number % LAP, Pose2.identity()) for number in range(LAP, LAPS * LAP + 1, LAP // 4)}


def test_error_stops_growing_where_places_are_recognised() -> None:
    assert abs(off(driven({})).theta_rad) > 0.015
    graph = driven(EVERY_QUARTER)
    assert abs(off(graph).theta_rad) < 0.001
    assert math.hypot(*off(graph)[:2]) < 0.002


def test_the_doubt_about_the_pose_stops_growing_as_well() -> None:
    after_lap = driven({}).belief("r1", stamp_ns(LAP)).covariance
    in_the_end = driven(EVERY_QUARTER).belief("r1", stamp_ns(LAPS * LAP)).covariance
    assert (np.diag(in_the_end) < np.diag(after_lap)).all()


def test_what_came_before_is_smoothed() -> None:
    half = LAP // 2
    without, with_one = driven({}), driven({LAP: EVERY_QUARTER[LAP]})
    assert abs(off(with_one, half).theta_rad) < 0.6 * abs(off(without, half).theta_rad)


def test_a_place_wrongly_recognised_moves_nobody_far() -> None:
    wrong = driven(EVERY_QUARTER | {LAPS * LAP: revisit(0, Pose2(0.05, 0.0, 0.0))})
    assert math.hypot(*off(wrong)[:2]) < 0.002


def test_a_place_whose_local_map_was_lost_tells_nothing() -> None:
    revisits = {LAP: revisit(3, STEP)}
    assert off(driven(revisits, lost=frozenset({3}))) == off(driven({}, lost=frozenset({3})))


def test_a_stamp_that_never_was_or_is_the_own_tells_nothing() -> None:
    for number in (LAP, LAP + 7):
        assert off(driven({LAP: revisit(number, Pose2(0.1, 0.0, 0.0))})) == off(driven({}))
