"""Keeping recorded time, on a clock that the test moves."""

from __future__ import annotations

import math

import pytest

from sim.pace import Pace

SECOND_NS = 1_000_000_000
START_NS = 1_412_172_400 * SECOND_NS


class MovableClock:
    """A clock that only its owner and those who sleep on it move forward."""

    def __init__(self) -> None:
        self.now_s = 100.0

    def __call__(self) -> float:
        return self.now_s

    def sleep(self, duration_s: float) -> None:
        assert duration_s > 0.0
        self.now_s += duration_s


def test_a_step_is_held_until_its_recorded_time() -> None:
    clock = MovableClock()
    pace = Pace(1.0, clock, clock.sleep)
    pace.hold(START_NS)
    assert clock.now_s == 100.0
    pace.hold(START_NS + SECOND_NS)
    assert clock.now_s == pytest.approx(101.0)


def test_twice_the_rate_takes_half_the_time() -> None:
    clock = MovableClock()
    pace = Pace(2.0, clock, clock.sleep)
    for second in range(5):
        pace.hold(START_NS + second * SECOND_NS)
    assert clock.now_s == pytest.approx(102.0)


def test_a_late_step_is_not_held_and_the_lag_is_told() -> None:
    clock = MovableClock()
    pace = Pace(1.0, clock, clock.sleep)
    pace.hold(START_NS)
    clock.now_s += 1.75
    pace.hold(START_NS + SECOND_NS)
    assert clock.now_s == 101.75
    assert (pace.lag_s, pace.worst_lag_s) == pytest.approx((0.75, 0.75))


def test_lost_time_is_made_up_where_the_listeners_are_fast_again() -> None:
    clock = MovableClock()
    pace = Pace(1.0, clock, clock.sleep)
    pace.hold(START_NS)
    clock.now_s += 1.75
    pace.hold(START_NS + SECOND_NS)
    pace.hold(START_NS + 2 * SECOND_NS)
    assert clock.now_s == pytest.approx(102.0)
    assert pace.report() == "played at 1 x recorded time, at worst 0.75 s late, 0.00 s at the end"


def test_as_fast_as_it_goes_never_sleeps_and_never_lags() -> None:
    clock = MovableClock()
    pace = Pace(math.inf, clock, clock.sleep)
    for second in range(3):
        pace.hold(START_NS + second * SECOND_NS)
        clock.now_s += 5.0
    assert clock.now_s == 115.0
    assert (pace.worst_lag_s, pace.report()) == (0.0, "played as fast as it goes")


@pytest.mark.parametrize("rate", [0.0, -1.0, math.nan])
def test_a_rate_that_never_plays_is_refused(rate: float) -> None:
    with pytest.raises(ValueError, match="would never play"):
        Pace(rate)
