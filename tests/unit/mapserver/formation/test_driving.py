"""The formation under way waits for whoever cannot follow, or stands where another one would go."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mapserver.formation.costmap import CostMap, cost_map
from mapserver.formation.driving import BETWEEN_M, REVIEW_EVERY_STEPS, WAITING_S, Driving
from mapserver.formation.floor import Bounds, Floor
from mapserver.formation.follow import Body, make_plan
from mapserver.formation.trail import STEP_M, Lane
from protocol.geometry import Pose2
from protocol.messages import FREE, OCCUPIED

BODY = Body(0.075, 0.15, 0.3)
TRAIL = Lane.through(np.stack([np.arange(0.2, 3.8, STEP_M), np.full(360, 1.5)], axis=1))
COLUMN = np.array([[0.26, 0.0], [0.5, 0.0]])
ARC_M, STEP_S = 1.0, 0.1


def open_floor() -> CostMap:
    return floor_with(())


def begun() -> tuple[Driving, dict[str, Pose2]]:
    """Return a column of three that is about to drive, and where its robots are: in their places."""
    drive = Driving(make_plan(TRAIL, ARC_M, ("r1", "r2", "r3"), COLUMN, BODY, open_floor(), (3.6, 1.5)), ARC_M, BODY)
    return drive, {name: reference.arena_from_body for name, reference in drive.plan.references(ARC_M, 0.0).items()}


def floor_with(things: tuple[tuple[slice, slice], ...]) -> CostMap:
    """Return open floor but for things, each given by its rows and columns of 1 cm."""
    cells = np.full((300, 400), FREE, np.uint8)
    for rows, columns in things:
        cells[rows, columns] = OCCUPIED
    return cost_map(Floor(cells, np.zeros(2), 0.01), Bounds(0.0, 0.0, 4.0, 3.0), TRAIL.points_m[:1], [])


def test_followers_use_the_room_that_the_map_shows_by_now() -> None:
    narrow = floor_with(((slice(165, 180), slice(100, 300)), (slice(120, 135), slice(100, 300))))
    wedge = np.array([[0.33, 0.23], [0.33, -0.23]])
    drive = Driving(make_plan(TRAIL, ARC_M, ("r1", "r2", "r3"), wedge, BODY, narrow, (3.6, 1.5)), ARC_M, BODY)
    ahead_m = ARC_M + np.array([0.6, 1.0])
    assert drive.plan.drawn_in_m(ahead_m).max() > 0.1
    poses = {name: reference.arena_from_body for name, reference in drive.plan.references(ARC_M, 0.0).items()}
    for _ in range(REVIEW_EVERY_STEPS):
        poses = {name: reference.arena_from_body for name, reference in drive.step(STEP_S, poses, open_floor()).items()}
    assert drive.plan.drawn_in_m(ahead_m).max() < 0.02


def test_it_sets_out_when_everybody_is_in_its_place() -> None:
    drive, poses = begun()
    drive.step(STEP_S, poses, open_floor())
    assert not drive.is_at_rest()
    assert drive.waits_for == ""


@pytest.mark.parametrize(("apart_m", "waits"), [(0.15 + BETWEEN_M - 0.005, True), (0.15 + BETWEEN_M + 0.01, False)])
def test_nobody_is_led_into_a_robot_that_stands_close_before_it(apart_m: float, waits: bool) -> None:
    drive, poses = begun()
    poses["r1"] = Pose2(poses["r2"].x_m + apart_m, 1.5, 0.0)
    drive.step(STEP_S, poses, open_floor())
    assert drive.waits_for == ("r1" if waits else "")
    assert drive.is_at_rest() == waits


@pytest.mark.parametrize(("behind_m", "waits"), [(0.006, True), (0.002, False)])
def test_the_nearer_robots_are_the_less_may_one_fall_behind(behind_m: float, waits: bool) -> None:
    drive, poses = begun()
    start = drive.plan.references(ARC_M, 0.0)
    leader = start["r1"].arena_from_body
    gap_m = leader.x_m - start["r2"].arena_from_body.x_m - 0.15
    near = Driving(drive.plan, ARC_M, replace(BODY, radius_m=0.075 + 0.5 * gap_m - 0.005))  # bodies so wide that 1 cm is left between them
    poses["r1"] = Pose2(leader.x_m - behind_m, leader.y_m, 0.0)
    near.step(STEP_S, poses, open_floor())
    assert near.waits_for == ("r1" if waits else "")


def test_a_robot_that_is_close_behind_holds_up_nobody() -> None:
    drive, poses = begun()
    poses |= {"r2": Pose2(poses["r2"].x_m - 0.09, 1.5, 0.0), "r3": Pose2(poses["r3"].x_m + 0.065, 1.5, 0.0)}
    assert poses["r2"].x_m - poses["r3"].x_m < 0.15 + BETWEEN_M
    drive.step(STEP_S, poses, open_floor())
    assert drive.waits_for == ""
    assert not drive.is_at_rest()


@pytest.mark.parametrize(("back_m_s", "is_over"), [(0.0, True), (0.08, False)])
def test_a_robot_that_steps_back_to_look_again_is_waited_for_longer_than_one_that_stands(back_m_s: float, is_over: bool) -> None:
    drive, poses = begun()
    for step in range(round((WAITING_S + 1.0) / STEP_S)):
        drive.step(STEP_S, poses | {"r3": Pose2(poses["r3"].x_m - 0.2 - back_m_s * step * STEP_S, 1.5, 0.0)}, open_floor())
    assert drive.waits_for == "r3"
    assert drive.is_over() == is_over
