"""When a robot steps back to see what holds it up."""

from __future__ import annotations

import math

import numpy as np
import pytest

from agent.control.limits import applied
from agent.control.near_things import NearThings
from agent.control.safety import Keeping, checked
from agent.control.second_look import AGAIN_S, BACK_M, BACK_S, HELD_S, LEFT_M, STILL_M, Hold
from agent.control.tracking import track
from agent.control.trail import Trail
from agent.control.twist import STANDING
from protocol.geometry import Pose2
from tests.unit.agent.control.local_maps import HIDDEN_M, box, local_map, region
from tests.unit.agent.control.unicycle import LIMITS, PERIOD_S, Unicycle

HERE = Pose2(1.0, 2.0, 0.5)
TICK_S = 0.125


def held_for_s(hold: Hold, most_s: float, every: int = 1) -> float:
    """Return after how long a robot that does not move, and is held only at one moment of `every`, steps back."""
    for tick in range(round(most_s / TICK_S)):
        if hold.steps_back:
            return tick * TICK_S
        hold = hold.after(TICK_S, HERE, blocked=True, held=tick % every == 0)
    return math.inf


def stepping() -> Hold:
    hold = Hold(HERE, held_s=HELD_S).after(TICK_S, HERE, blocked=True, held=True)
    assert hold.steps_back
    return hold


def test_a_robot_held_for_some_seconds_steps_back() -> None:
    assert held_for_s(Hold(HERE), 60.0) == pytest.approx(HELD_S)


def test_one_that_is_held_now_and_then_at_one_place_does_so_as_well() -> None:
    assert held_for_s(Hold(HERE), 60.0, every=2) == pytest.approx(2.0 * HELD_S, abs=TICK_S)


def test_one_that_gets_on_or_is_not_held_does_not() -> None:
    for held, step_m in ((True, 1.01 * STILL_M), (False, 0.0)):
        hold = Hold(HERE)
        for tick in range(100):
            hold = hold.after(TICK_S, Pose2(1.0 + tick * step_m, 2.0, 0.5), blocked=True, held=held)
            assert not hold.steps_back


@pytest.mark.parametrize(
    ("away_m", "blocked", "is_over"), [(BACK_M + 0.001, False, True), (0.05, True, True), (BACK_M - 0.01, False, False)]
)
def test_it_steps_back_far_enough_or_until_something_is_behind_it(away_m: float, blocked: bool, is_over: bool) -> None:
    hold = stepping().after(TICK_S, HERE @ Pose2(-away_m, 0.0, 0.0), blocked=blocked, held=False)
    assert hold.steps_back != is_over
    assert hold.has_looked == is_over


def test_one_that_could_not_step_back_soon_tries_again() -> None:
    assert held_for_s(stepping().after(TICK_S, HERE, blocked=True, held=False), 60.0) == pytest.approx(HELD_S)


def test_it_does_not_try_for_ever() -> None:
    hold = stepping()
    for _ in range(round(BACK_S / TICK_S) + 2):
        hold = hold.after(TICK_S, HERE @ Pose2(-0.05, 0.0, 0.0), blocked=False, held=False)
    assert hold.has_looked
    assert not hold.steps_back


def test_at_the_same_place_it_looks_again_only_after_long() -> None:
    looked = stepping().after(TICK_S, HERE @ Pose2(-0.05, 0.0, 0.0), blocked=True, held=False)
    assert held_for_s(looked, 60.0) == pytest.approx(AGAIN_S)
    near = looked.after(TICK_S, HERE @ Pose2(0.9 * LEFT_M, 0.0, 0.0), blocked=False, held=False)
    assert near.has_looked
    assert not near.after(TICK_S, HERE @ Pose2(1.01 * LEFT_M, 0.0, 0.0), blocked=False, held=False).has_looked


@pytest.mark.parametrize("bearing_rad", [0.0, 0.6, -1.2])
def test_from_back_there_all_can_be_seen_that_was_beside_the_body(bearing_rad: float) -> None:
    point = 0.095 * np.array([math.cos(bearing_rad), math.sin(bearing_rad)])
    assert math.dist(point, (-BACK_M, 0.0)) > HIDDEN_M


@pytest.mark.parametrize(("is_there", "least_m", "most_m"), [(False, 0.5, 1.1), (True, 0.05, 0.13)])
def test_a_robot_drives_over_what_only_seemed_to_be_there_and_not_into_what_is(is_there: bool, least_m: float, most_m: float) -> None:
    keeping, post = Keeping(0.075, 0.02), box(0.23, 0.0, 0.03, 0.03)
    robot, near, trail = Unicycle(Pose2(-0.3, 0.0, 0.0)), NearThings(keeping.radius_m), Trail()
    command, hold, farthest_m = STANDING, Hold(), -1.0
    for step in range(200):
        seen = robot.pose.inverse().apply(post)
        shown = np.hypot(*seen.T).min() > HIDDEN_M and (is_there or step < 20)
        near.see(local_map(100 * step, [region(seen)] if shown else [], odom_from_body=robot.pose))
        trail.note(robot.pose)
        target = trail.back(robot.pose) if hold.steps_back else Pose2(1.0, 0.0, 0.0)
        wanted = applied(track(robot.pose.between(target), STANDING), command, PERIOD_S, LIMITS)
        safe = checked(wanted, near.around(robot.pose), keeping)
        hold, command = hold.after(PERIOD_S, robot.pose, blocked=safe.blocked, held=safe.blocked), safe.twist
        robot.drive(command)
        farthest_m = max(farthest_m, robot.pose.x_m)
    assert least_m < farthest_m < most_m
