"""Speed and turn rate, and the wheels that make them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from agent.control.twist import Twist, wheel_speeds, within_wheel_speed
from agent.slam.odometry import WheelGeometry, travel

WHEELS = WheelGeometry(radius_m=0.03, base_m=0.12)
speeds = st.floats(-50.0, 50.0)


def test_straight_on_both_wheels_turn_alike() -> None:
    assert wheel_speeds(Twist(0.15, 0.0), WHEELS) == pytest.approx((5.0, 5.0))


def test_on_the_spot_the_wheels_turn_against_each_other() -> None:
    assert wheel_speeds(Twist(0.0, 1.0), WHEELS) == pytest.approx((-2.0, 2.0))


@given(st.floats(-1.0, 1.0), st.floats(-5.0, 5.0))
def test_wheels_move_the_body_as_was_asked(speed_m_s: float, turn_rad_s: float) -> None:
    distance_m, turn_rad = travel(np.array(wheel_speeds(Twist(speed_m_s, turn_rad_s), WHEELS)), WHEELS)  # in one second
    assert (distance_m, turn_rad) == pytest.approx((speed_m_s, turn_rad_s), abs=1e-12)


@given(speeds, speeds)
def test_wheels_that_are_too_fast_are_slowed_on_the_same_arc(left: float, right: float) -> None:
    slow_left, slow_right = within_wheel_speed(left, right, 12.0)
    assert max(abs(slow_left), abs(slow_right)) <= 12.0 + 1e-9
    assert slow_left * right == pytest.approx(slow_right * left, abs=1e-6)


def test_a_quarter_circle() -> None:
    pose = Twist(0.1, math.pi / 2).motion(1.0)
    radius_m = 0.1 / (math.pi / 2)
    assert pose == pytest.approx((radius_m, radius_m, math.pi / 2))
