"""The differential drive against closed forms worked out here."""

from __future__ import annotations

import math

import pytest

from protocol.geometry import Pose2
from sim.world.drive import FASTEST_RAD_S, FULL_GRIP, STILL, Drive, Turning, Wheels, encoder_angles_rad, moved, rolled_m, turned

DRIVE = Drive(wheel_base_m=0.12, radii_m=Wheels(0.03, 0.03), encoder_ticks_per_rev=1000, motor_lag_s=0.1, slip_m_per_sqrt_m=0.0)
STANDING = Turning(STILL, STILL)


def test_a_motor_reaches_63_percent_of_its_command_after_its_time_constant() -> None:
    after = turned(DRIVE, STANDING, Wheels(5.0, -5.0), 0.1)
    assert after.speeds_rad_s == pytest.approx((5.0 * (1 - 1 / math.e), -5.0 * (1 - 1 / math.e)))


def test_the_angle_does_not_depend_on_the_length_of_the_substeps() -> None:
    once = turned(DRIVE, STANDING, Wheels(5.0, 3.0), 0.5)
    often = STANDING
    for _ in range(100):
        often = turned(DRIVE, often, Wheels(5.0, 3.0), 0.005)
    assert often.angles_rad == pytest.approx(once.angles_rad)
    assert once.angles_rad.left == pytest.approx(5.0 * 0.5 - 5.0 * 0.1 * (1.0 - math.exp(-5.0)))


def test_a_motor_without_lag_turns_as_told_at_once() -> None:
    drive = Drive(0.12, Wheels(0.03, 0.03), 1000, motor_lag_s=0.0, slip_m_per_sqrt_m=0.0)
    assert turned(drive, STANDING, Wheels(4.0, 2.0), 0.25) == (Wheels(4.0, 2.0), Wheels(1.0, 0.5))


def test_a_motor_gives_no_more_than_it_can() -> None:
    assert turned(DRIVE, STANDING, Wheels(1e12, -1e12), 10.0).speeds_rad_s == pytest.approx((FASTEST_RAD_S, -FASTEST_RAD_S))


def test_equal_ways_drive_straight_and_opposite_ones_turn_on_the_spot() -> None:
    assert moved(DRIVE, Pose2(1.0, 2.0, math.pi / 2), Wheels(0.3, 0.3)) == pytest.approx((1.0, 2.3, math.pi / 2))
    assert moved(DRIVE, Pose2(1.0, 2.0, 0.0), Wheels(-0.06, 0.06)) == pytest.approx((1.0, 2.0, 1.0))


def test_unequal_ways_drive_a_circle_of_the_radius_that_eq_1_gives() -> None:
    radius_m = 0.5  # v / omega
    angle_rad = math.pi / 2
    ways = Wheels((radius_m - 0.06) * angle_rad, (radius_m + 0.06) * angle_rad)
    assert moved(DRIVE, Pose2.identity(), ways) == pytest.approx((0.5, 0.5, math.pi / 2))


def test_a_slipping_wheel_turns_without_moving_the_robot() -> None:
    ways = rolled_m(DRIVE, Wheels(10.0, 10.0), grip=Wheels(0.0, 1.0), noise=STILL)
    assert ways == pytest.approx((0.0, 0.3))


def test_slip_grows_with_the_root_of_the_way() -> None:
    drive = Drive(0.12, Wheels(0.03, 0.03), 1000, 0.0, slip_m_per_sqrt_m=0.002)
    ways = rolled_m(drive, Wheels(4.0 / 0.03, 0.0), FULL_GRIP, noise=Wheels(1.0, 1.0))
    assert ways == pytest.approx((4.0 + 0.004, 0.0))


def test_encoders_tell_whole_ticks_and_lag_by_less_than_one() -> None:
    told = encoder_angles_rad(DRIVE, Wheels(1.0, -1.0))
    tick_rad = 2.0 * math.pi / 1000
    for angle, true in zip(told, (1.0, -1.0), strict=True):
        assert angle / tick_rad == pytest.approx(round(angle / tick_rad))
        assert 0.0 <= true - angle < tick_rad
