"""What a robot may do."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agent.control.limits import BRAKING, DriveLimits, applied, within_accelerations, within_speeds
from agent.control.twist import STANDING, Twist

LIMITS = DriveLimits(max_speed_m_s=0.25, max_turn_rad_s=2.5, max_acceleration_m_s2=0.6, max_turn_acceleration_rad_s2=12.0)
wanted = st.builds(Twist, st.floats(-10.0, 10.0), st.floats(-50.0, 50.0))
possible = st.builds(Twist, st.floats(-0.25, 0.25), st.floats(-2.5, 2.5))


def test_too_fast_an_arc_is_driven_more_slowly() -> None:
    assert within_speeds(Twist(0.5, 1.0), LIMITS) == pytest.approx((0.25, 0.5))
    assert within_speeds(Twist(0.2, 5.0), LIMITS) == pytest.approx((0.1, 2.5))


def test_what_is_within_the_limits_is_left_as_it_is() -> None:
    assert within_speeds(Twist(-0.2, 2.0), LIMITS) == Twist(-0.2, 2.0)


def test_speed_grows_by_the_acceleration_and_falls_twice_as_fast() -> None:
    assert within_accelerations(Twist(0.25, 0.0), STANDING, 0.1, LIMITS) == pytest.approx((0.06, 0.0))
    assert within_accelerations(Twist(0.0, 0.0), Twist(0.2, 0.0), 0.1, LIMITS) == pytest.approx((0.08, 0.0))
    assert within_accelerations(Twist(-0.2, 0.0), Twist(0.05, 0.0), 0.1, LIMITS) == pytest.approx((-0.06, 0.0))


def test_to_stand_is_allowed_at_once() -> None:
    assert applied(STANDING, Twist(0.25, 2.5), 0.1, LIMITS) == STANDING


@given(wanted, possible, st.floats(0.0, 0.2))
def test_nothing_exceeds_a_limit(asked: Twist, last: Twist, elapsed_s: float) -> None:
    given_back = applied(asked, last, elapsed_s, LIMITS)
    assert abs(given_back.speed_m_s) <= 0.25 + 1e-9
    assert abs(given_back.turn_rad_s) <= 2.5 + 1e-9
    if asked != STANDING:
        assert abs(given_back.speed_m_s - last.speed_m_s) <= BRAKING * 0.6 * elapsed_s + 1e-9
        assert abs(given_back.turn_rad_s - last.turn_rad_s) <= BRAKING * 12.0 * elapsed_s + 1e-9
        assert abs(given_back.speed_m_s) <= abs(last.speed_m_s) + 0.6 * elapsed_s + 1e-9
