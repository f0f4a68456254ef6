"""The tracking law, by hand and in closed loop with motors that lag."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from agent.control.tracking import CATCH_UP_M_S, DEAD_M, DEAD_RAD, FAR_M, REVERSE_M, Reference, track
from agent.control.twist import STANDING, Twist
from protocol.geometry import Pose2
from tests.unit.agent.control.unicycle import Unicycle, errors_while_following

ARRIVES_S = 30.0
offsets = st.builds(Pose2, st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), st.floats(-math.pi, math.pi))


def distance(pose: Pose2) -> float:
    return math.hypot(pose.x_m, pose.y_m)


def test_on_its_reference_the_robot_moves_as_that_does() -> None:
    assert track(Pose2.identity(), Twist(0.15, 0.4)) == pytest.approx((0.15, 0.4))


def test_a_reference_ahead_is_caught_up_with_and_one_behind_is_waited_for() -> None:
    assert track(Pose2(0.05, 0.0, 0.0), Twist(0.15, 0.0)) == pytest.approx((0.24, 0.0))
    assert track(Pose2(-0.05, 0.0, 0.0), Twist(0.15, 0.0)) == pytest.approx((0.06, 0.0))
    assert track(Pose2(0.25, 0.0, 0.0), Twist(0.15, 0.0)).speed_m_s == pytest.approx(0.15 + CATCH_UP_M_S)


def test_a_reference_to_the_left_is_steered_to_on_the_left() -> None:
    assert track(Pose2(0.0, 0.05, 0.0), Twist(0.15, 0.0)).turn_rad_s > 0.0
    assert track(Pose2(0.0, -0.05, 0.0), Twist(0.15, 0.0)).turn_rad_s < 0.0
    assert track(Pose2(0.0, 0.05, 0.0), Twist(-0.15, 0.0)).turn_rad_s < 0.0  # going backwards, the other way round


def test_a_reference_that_stands_aside_is_turned_to_on_the_spot() -> None:
    assert track(Pose2(0.0, 0.1, 0.0), STANDING).speed_m_s == 0.0
    assert track(Pose2(0.0, 0.1, 0.0), STANDING).turn_rad_s > 0.0


def test_a_far_reference_is_turned_to_on_the_spot_even_while_it_moves() -> None:
    assert track(Pose2(0.0, -FAR_M - 0.1, 0.0), Twist(0.15, 0.0)).speed_m_s == 0.0


def test_a_place_just_behind_is_backed_up_to_gently() -> None:
    command = track(Pose2(-0.5 * REVERSE_M, 0.0, 0.0), STANDING)
    assert -0.08 <= command.speed_m_s < 0.0
    assert command.turn_rad_s == pytest.approx(0.0, abs=1e-12)


def test_in_the_right_place_only_the_heading_is_made_up_for() -> None:
    assert track(Pose2(0.0, 0.005, 0.5), STANDING) == pytest.approx((0.0, 1.1))


@given(st.floats(-0.99 * DEAD_M, 0.99 * DEAD_M), st.floats(-0.99 * DEAD_M, 0.99 * DEAD_M), st.floats(-0.99 * DEAD_RAD, 0.99 * DEAD_RAD))
def test_a_robot_at_rest_does_not_dither(x_m: float, y_m: float, theta_rad: float) -> None:
    assert track(Pose2(x_m, y_m, theta_rad), STANDING) == STANDING


def test_a_reference_goes_on_along_its_arc() -> None:
    later = Reference(Pose2(1.0, 2.0, math.pi / 2), Twist(0.2, 0.0)).later(0.5)
    assert later.arena_from_body == pytest.approx((1.0, 2.1, math.pi / 2))
    assert later.twist == Twist(0.2, 0.0)


@settings(max_examples=40, deadline=None)
@given(offsets, st.sampled_from([(0.15, 0.0), (0.15, 0.5), (0.1, -0.4), (0.05, 0.0), (-0.1, 0.0)]), st.integers(0, 100))
def test_a_robot_comes_up_to_a_moving_reference_from_anywhere_and_stays_with_it(
    offset: Pose2, twist: tuple[float, float], seed: int
) -> None:
    reference = Reference(Pose2.identity(), Twist(*twist))
    errors = list(errors_while_following(Unicycle(offset), reference, ARRIVES_S, np.random.default_rng(seed)))
    assert max(distance(error) for error in errors[-50:]) < 0.005
    assert max(abs(error.theta_rad) for error in errors[-50:]) < math.radians(3.0)


@settings(max_examples=40, deadline=None)
@given(offsets, st.integers(0, 100))
def test_a_robot_comes_to_rest_at_a_place_from_anywhere(offset: Pose2, seed: int) -> None:
    robot = Unicycle(offset)
    reference = Reference(Pose2.identity(), STANDING)
    errors = list(errors_while_following(robot, reference, ARRIVES_S, np.random.default_rng(seed)))
    assert max(distance(error) for error in errors[-20:]) < 0.02
    assert abs(errors[-1].theta_rad) < math.radians(3.0)
