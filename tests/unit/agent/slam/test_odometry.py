"""Motion from the wheels by Eq. 1, its covariance, and wheel angles between and beyond readings."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from agent.slam.odometry import WheelGeometry, WheelNoise, angles_at, arc_motion, euler_motion, motion_covariance, travel
from protocol.errors import GeometryError
from protocol.geometry import Array, Pose2

WHEELS = WheelGeometry(radius_m=0.03, base_m=0.12)
NOISE = WheelNoise(scale=0.01, slip_m_per_sqrt_m=0.005, tick_rad=0.006, speed_m_s=0.1)
STAMPS_NS = np.array([0, 20, 40, 60, 80], np.int64) * 1_000_000
ANGLES_RAD = np.array([[0.0, 0.0], [0.1, 0.2], [0.2, 0.4], [0.3, 0.6], [0.4, 0.8]])


def test_travel_by_hand() -> None:
    # 2 and 4 rad: 0.06 and 0.12 m; on average 0.09 m; 0.06 m of difference over a base of 0.12 m.
    assert travel(np.array([2.0, 4.0]), WHEELS) == pytest.approx((0.09, 0.5))


def test_wheels_of_two_sizes_go_two_ways() -> None:
    distance_m, turn_rad = travel(np.array([2.0, 2.0]), WheelGeometry(0.03, 0.12, scale=(1.0, 1.04)))
    assert distance_m == pytest.approx(0.0612)
    assert turn_rad == pytest.approx(0.02)


def test_equation_1_as_printed_goes_straight_on_along_the_old_heading() -> None:
    here = Pose2(1.0, 2.0, math.radians(30.0))
    there = here @ euler_motion(np.array([2.0, 4.0]), WHEELS)
    assert there == pytest.approx((1.0 + 0.09 * math.cos(here.theta_rad), 2.0 + 0.09 * math.sin(here.theta_rad), here.theta_rad + 0.5))


def test_an_arc_follows_its_circle() -> None:
    # Radius d / dtheta = 0.09 / 0.5 = 0.18 m.
    assert arc_motion(np.array([2.0, 4.0]), WHEELS) == pytest.approx((0.18 * math.sin(0.5), 0.18 * (1.0 - math.cos(0.5)), 0.5))


def test_wheels_against_each_other_turn_on_the_spot() -> None:
    assert arc_motion(np.array([-2.0, 2.0]), WHEELS) == pytest.approx((0.0, 0.0, 1.0))


def test_equal_wheels_go_straight_in_both_forms() -> None:
    assert arc_motion(np.array([3.0, 3.0]), WHEELS) == euler_motion(np.array([3.0, 3.0]), WHEELS) == pytest.approx((0.09, 0.0, 0.0))


@given(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))
def test_many_short_steps_of_equation_1_make_the_arc(left: float, right: float) -> None:
    pose = Pose2.identity()
    for _ in range(400):
        pose = pose @ euler_motion(np.array([left, right]) / 400, WHEELS)
    assert pose == pytest.approx(arc_motion(np.array([left, right]), WHEELS), abs=5e-4)


@given(st.floats(-6.0, 6.0), st.floats(-6.0, 6.0), st.floats(0.0, 1.0))
def test_a_covariance_is_symmetric_and_positive(left: float, right: float, extrapolated_s: float) -> None:
    covariance = motion_covariance(np.array([left, right]), WHEELS, NOISE, extrapolated_s)
    assert covariance == pytest.approx(covariance.T, abs=1e-15)
    assert (np.linalg.eigvalsh(covariance) > 0.0).all()


def test_covariance_of_a_straight_way_by_hand() -> None:
    # Both wheels turn 10 rad: 0.3 m. var = (0.01 * 0.3)^2 + 0.005^2 * 0.3 + (0.006 * 0.03)^2 / 6 = 9e-6 + 7.5e-6 + 5.4e-9 each.
    wheel = 9e-6 + 7.5e-6 + 5.4e-9
    covariance = motion_covariance(np.array([10.0, 10.0]), WHEELS, NOISE)
    assert covariance[0, 0] == pytest.approx(wheel / 2.0)
    assert covariance[2, 2] == pytest.approx(2.0 * wheel / 0.12**2)
    assert covariance[1, 2] == pytest.approx(0.15 * covariance[2, 2])  # an error of heading grows over half of the way
    assert covariance[0, 1] == pytest.approx(0.0, abs=1e-12)


def test_covariance_matches_a_sample_of_noisy_arcs() -> None:
    rng = np.random.default_rng(5)
    angles = np.array([8.0, 14.0])
    no_slip = WheelNoise(scale=0.01, slip_m_per_sqrt_m=0.0, tick_rad=0.0, speed_m_s=0.0)
    true = arc_motion(angles, WHEELS)
    errors = np.array([true.between(arc_motion(angles * (1.0 + rng.normal(0.0, 0.01, 2)), WHEELS)).log() for _ in range(4000)])
    assert np.sqrt(np.diag(motion_covariance(angles, WHEELS, no_slip))) == pytest.approx(errors.std(axis=0), rel=0.06)


def test_guessing_longer_is_believed_less() -> None:
    def at(seconds: float) -> Array:
        return motion_covariance(np.array([1.0, 1.0]), WHEELS, NOISE, seconds)

    assert at(0.2)[0, 0] - at(0.0)[0, 0] == pytest.approx(0.5 * (0.1 * 0.2) ** 2)


@pytest.mark.parametrize(("stamp_ms", "expected"), [(0, [0.0, 0.0]), (30, [0.15, 0.3]), (80, [0.4, 0.8]), (-50, [0.0, 0.0])])
def test_angles_between_readings_are_interpolated_and_before_the_first_they_stand(stamp_ms: int, expected: list[float]) -> None:
    angles, guessed_s = angles_at(STAMPS_NS, ANGLES_RAD, stamp_ms * 1_000_000)
    assert angles == pytest.approx(expected)
    assert guessed_s == 0.0


def test_after_the_last_reading_the_wheels_keep_their_speed() -> None:
    angles, guessed_s = angles_at(STAMPS_NS, ANGLES_RAD, 100_000_000)
    assert angles == pytest.approx([0.5, 1.0])
    assert guessed_s == pytest.approx(0.02)


def test_long_after_the_last_reading_the_wheels_stand() -> None:
    angles, guessed_s = angles_at(STAMPS_NS, ANGLES_RAD, 5_080_000_000, max_extrapolation_s=0.2)
    assert angles == pytest.approx([0.4 + 5.0 * 0.2, 0.8 + 10.0 * 0.2])
    assert guessed_s == pytest.approx(5.0)


def test_the_speed_is_the_mean_of_the_span_so_that_one_encoder_step_does_not_show() -> None:
    stepped = ANGLES_RAD.copy()
    stepped[3] += 0.006
    assert angles_at(STAMPS_NS, stepped, 100_000_000, speed_span_s=0.08)[0] == pytest.approx([0.5, 1.0])


def test_a_single_reading_holds() -> None:
    angles, guessed_s = angles_at(STAMPS_NS[:1], ANGLES_RAD[1:2], 60_000_000)
    assert angles == pytest.approx([0.1, 0.2])
    assert guessed_s == pytest.approx(0.06)


def test_stamps_of_today_lose_no_nanosecond() -> None:
    epoch_ns = 1_763_770_000_123_456_789
    angles, _ = angles_at(STAMPS_NS + epoch_ns, ANGLES_RAD, epoch_ns + 50_000_000)
    assert angles == pytest.approx([0.25, 0.5], abs=1e-12)


def test_no_readings_or_readings_that_run_backwards_are_refused() -> None:
    with pytest.raises(GeometryError, match="at least one"):
        angles_at(STAMPS_NS[:0], ANGLES_RAD[:0], 0)
    with pytest.raises(GeometryError, match="ascend"):
        angles_at(STAMPS_NS[::-1], ANGLES_RAD, 0)


@pytest.mark.parametrize(("radius_m", "base_m"), [(0.0, 0.12), (0.03, -0.12), (math.nan, 0.12), (0.03, math.inf)])
def test_wheels_that_cannot_roll_are_refused(radius_m: float, base_m: float) -> None:
    with pytest.raises(GeometryError, match="wheels"):
        WheelGeometry(radius_m, base_m)
