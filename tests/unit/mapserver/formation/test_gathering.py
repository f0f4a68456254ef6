"""Gathering: robots drive to their slots, and one that cannot go its way ends the attempt."""

from __future__ import annotations

import numpy as np

from mapserver.formation.costmap import CostMap, cost_map
from mapserver.formation.floor import Bounds, Floor
from mapserver.formation.follow import Body
from mapserver.formation.forming import form_up
from mapserver.formation.gathering import Gathering
from mapserver.formation.onward import berth_of
from mapserver.formation.planning import Reach
from mapserver.formation.shapes import Shape
from protocol.geometry import Pose2
from protocol.messages import FREE

STEP_S, LONGEST_S = 0.1, 60.0
BODY = Body(0.075, 0.15, 0.22)
GOAL_M = (3.4, 1.5)
STARTS = {"r1": Pose2(1.0, 1.5, 0.0), "r2": Pose2(1.6, 2.4, 2.0)}  # the follower stands ahead of the leader


def scene() -> CostMap:
    return cost_map(Floor(np.full((300, 400), FREE, np.uint8), np.zeros(2), 0.01), Bounds(0.0, 0.0, 4.0, 3.0), np.array([GOAL_M]), [])


def gathering() -> Gathering:
    start = form_up(STARTS, "r1", GOAL_M, Reach(scene(), np.array(GOAL_M), berth_of(BODY)), Shape("column", 0.45), BODY, scene())
    assert start is not None
    return Gathering(start.plan, start.arc_m, STARTS, BODY)


def test_robots_that_go_where_they_should_gather() -> None:
    under_way, poses = gathering(), dict(STARTS)
    for _ in range(round(LONGEST_S / STEP_S)):
        if under_way.is_done():
            break
        poses = {name: reference.arena_from_body for name, reference in under_way.step(STEP_S, poses, scene()).items()}
        assert not under_way.has_failed()
    assert under_way.is_done()


def test_a_robot_that_cannot_go_its_way_though_the_map_is_clear_ends_the_attempt() -> None:
    under_way = gathering()
    assert under_way.missing()
    steps = next(step for step in range(round(LONGEST_S / STEP_S)) if (under_way.step(STEP_S, STARTS, scene()), under_way.has_failed())[1])
    assert steps * STEP_S < 10.0
