"""The local guard: what it lets through, by hand, and that no drive of any kind ends in a thing."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from agent.control.borders import Borders
from agent.control.limits import applied
from agent.control.near_things import NearThings
from agent.control.safety import CREEP_M_S, LEAST_M, MOVING_EXTRA_M, SLOW_M, STEP_M, Checked, Keeping, checked, free_way_m
from agent.control.tracking import track
from agent.control.twist import STANDING, Twist
from protocol.geometry import Array, Pose2
from tests.unit.agent.control.local_maps import box, local_map, seen_from
from tests.unit.agent.control.unicycle import LIMITS, PERIOD_S, Unicycle

KEEPING = Keeping(radius_m=0.075, margin_m=0.02, max_speed_m_s=0.25)
AHEAD = Twist(0.25, 0.0)


def things(*points_m: tuple[float, float], moving: bool = False) -> Borders:
    return Borders(np.array(points_m, dtype=np.float64).reshape(-1, 2), np.full(len(points_m), moving))


def test_the_way_is_free_up_to_the_margin() -> None:
    assert free_way_m(AHEAD, things((0.155, 0.0)), KEEPING) == pytest.approx(0.06, abs=STEP_M)
    assert free_way_m(AHEAD, things((0.155, 0.0), moving=True), KEEPING) == pytest.approx(0.06 - MOVING_EXTRA_M, abs=STEP_M)
    assert free_way_m(AHEAD, things((0.5, 0.0)), KEEPING) == SLOW_M
    assert free_way_m(AHEAD, things(), KEEPING) == SLOW_M


def test_what_stands_beside_the_way_does_not_count() -> None:
    assert free_way_m(AHEAD, things((0.1, 0.1), (0.1, -0.1)), KEEPING) == SLOW_M


def test_the_way_follows_the_arc() -> None:
    left = Twist(0.1, 1.0)  # on a circle of 0.1 m round (0, 0.1)
    assert free_way_m(left, things((0.19, 0.0)), KEEPING) > free_way_m(Twist(0.1, 0.0), things((0.19, 0.0)), KEEPING)
    assert free_way_m(left, things((0.12, 0.12)), KEEPING) < SLOW_M


def test_the_nearer_a_thing_the_slower_the_robot() -> None:
    speeds = [checked(AHEAD, things((0.095 + free, 0.0)), KEEPING).twist.speed_m_s for free in (0.2, 0.09, 0.06, 0.03)]
    assert speeds[0] == 0.25
    assert speeds == sorted(speeds, reverse=True)
    for free, speed in zip((0.09, 0.06, 0.03), speeds[1:], strict=True):
        assert speed <= 0.25 * free / SLOW_M + 1e-9


def test_at_the_margin_the_robot_stands_and_may_turn() -> None:
    assert checked(Twist(0.2, 0.7), things((0.096, 0.0)), KEEPING) == Checked(Twist(0.0, 0.7), slowed=True, blocked=True)


@pytest.mark.parametrize(("beside_m", "passes"), [(0.018, True), (0.010, False)])
def test_what_is_a_little_nearer_to_the_way_than_the_margin_is_passed_at_a_creep(beside_m: float, passes: bool) -> None:
    beside = checked(AHEAD, things((0.022, KEEPING.radius_m + beside_m)), KEEPING)
    assert beside.blocked != passes
    assert abs(beside.twist.speed_m_s) <= CREEP_M_S


def test_what_moves_is_not_crept_by() -> None:
    assert checked(AHEAD, things((0.022, KEEPING.radius_m + 0.030), moving=True), KEEPING).blocked


def test_turning_on_the_spot_is_always_free() -> None:
    assert checked(Twist(0.0, 2.0), things((0.05, 0.0), (0.0, 0.08)), KEEPING) == Checked(Twist(0.0, 2.0), slowed=False, blocked=False)


def test_leaving_what_is_too_near_is_free_and_coming_nearer_is_not() -> None:
    near = things((0.08, 0.0))
    assert checked(Twist(-0.1, 0.0), near, KEEPING).twist == Twist(-0.1, 0.0)
    assert checked(Twist(0.1, 0.0), near, KEEPING).blocked


def test_many_small_approaches_do_not_add_up_to_a_touch() -> None:
    robot, post, aside_rad = Unicycle(Pose2(0.0, 0.0, math.radians(20.0))), np.array([0.0, 0.097]), math.radians(70.0)
    for _ in range(200):  # round a post, and always a little towards it
        x_m, y_m = robot.pose.inverse().apply(post)
        turn_rad_s = 2.0 * (math.atan2(y_m, x_m) - aside_rad)
        robot.drive(checked(Twist(0.1, turn_rad_s), things((float(x_m), float(y_m))), KEEPING).twist)
        assert np.hypot(*robot.pose.inverse().apply(post)) > KEEPING.radius_m + LEAST_M - 0.002


def test_a_gap_twice_as_wide_as_the_robot_can_be_driven_through() -> None:
    posts = [box(1.0, 0.26), box(1.0, -0.26)]  # 0.32 m apart
    path = drive(Unicycle(Pose2(0.0, 0.03, 0.1)), posts, Pose2(2.0, 0.0, 0.0), 20.0)
    assert path[-1].x_m > 1.9


def test_a_wall_across_the_way_is_stopped_at() -> None:
    path = drive(Unicycle(Pose2.identity()), [box(0.7, 0.0, 0.2, 2.0)], Pose2(2.0, 0.0, 0.0), 20.0)
    assert 0.6 - 0.075 - 0.05 < path[-1].x_m < 0.6 - 0.075


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10_000))
@example(649)  # a thing that is seen for a moment before the own body hides it
def test_whatever_it_is_told_the_robot_runs_into_nothing(seed: int) -> None:
    random = np.random.default_rng(seed)
    outlines = [box(*random.uniform(-1.2, 1.2, 2), *random.uniform(0.05, 0.4, 2)) for _ in range(8)]
    outlines = [outline for outline in outlines if clearance(Pose2.identity(), [outline]) > 0.13]  # so that all are seen once
    target = Pose2(random.uniform(-1.5, 1.5), random.uniform(-1.5, 1.5), 0.0)
    path = drive(Unicycle(Pose2(0.0, 0.0, random.uniform(-math.pi, math.pi))), outlines, target, 8.0)
    assert min(clearance(pose, outlines) for pose in path) > 0.0


def drive(robot: Unicycle, outlines: list[Array], target: Pose2, duration_s: float) -> list[Pose2]:
    """Drive straight for a target that knows of no obstacles; return the robot's poses."""
    near, command, path = NearThings(KEEPING.radius_m), STANDING, []
    for step in range(round(duration_s / PERIOD_S)):
        near.see(local_map(100 * step, seen_from(robot.pose, outlines), odom_from_body=robot.pose))
        wanted = applied(track(robot.pose.between(target), STANDING), command, PERIOD_S, LIMITS)
        command = checked(wanted, near.around(robot.pose), KEEPING).twist
        robot.drive(command)
        path.append(robot.pose)
    return path


def clearance(pose: Pose2, outlines: list[Array]) -> float:
    """Return how far the body is from the nearest thing, negative inside one."""
    nearest = math.inf
    for outline in outlines:
        low, high = outline.min(axis=0), outline.max(axis=0)
        outside = np.maximum(np.maximum(low - pose[:2], pose[:2] - high), 0.0)
        nearest = min(nearest, float(np.hypot(*outside)) - KEEPING.radius_m)
    return nearest
