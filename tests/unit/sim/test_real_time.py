"""A simulated world's pace, on a clock that the test sets."""

from __future__ import annotations

import math

import pytest

from sim.real_time import RealTime
from tests.set_clock import SetClock

PERIOD_NS = 100_000_000


@pytest.fixture
def clock() -> SetClock:
    return SetClock(50.0)


def begin(pace: RealTime, clock: SetClock, times_s: list[float]) -> None:
    """Begin one step after the other at these times since the first."""
    for number, time_s in enumerate(times_s):
        clock.now_s = 50.0 + time_s
        pace.began(number * PERIOD_NS)


def test_the_first_step_is_due_at_once_and_the_next_a_period_later(clock: SetClock) -> None:
    pace = RealTime(1.0, clock)
    assert pace.due_s(0) < 50.0
    pace.began(0)
    assert pace.due_s(PERIOD_NS) == pytest.approx(50.1)


def test_a_rate_below_one_stretches_time(clock: SetClock) -> None:
    pace = RealTime(0.5, clock)
    pace.began(0)
    assert pace.due_s(PERIOD_NS) == pytest.approx(50.2)


def test_as_fast_as_it_goes_is_always_due(clock: SetClock) -> None:
    pace = RealTime(math.inf, clock)
    begin(pace, clock, [0.0, 0.3])
    assert pace.due_s(2 * PERIOD_NS) <= clock.now_s
    assert (pace.late_steps, pace.worst_late_s) == (0, 0.0)


def test_a_little_lateness_does_not_add_up(clock: SetClock) -> None:
    pace = RealTime(1.0, clock)
    begin(pace, clock, [0.0, 0.11, 0.21, 0.31])
    assert pace.due_s(4 * PERIOD_NS) == pytest.approx(50.4)
    assert pace.late_steps == 0


def test_what_a_late_step_has_lost_is_not_caught_up(clock: SetClock) -> None:
    pace = RealTime(1.0, clock)
    begin(pace, clock, [0.0, 0.4])
    assert pace.due_s(2 * PERIOD_NS) == pytest.approx(50.5)
    assert (pace.late_steps, pace.worst_late_s) == pytest.approx((1, 0.3))


def test_world_and_real_time_are_told_apart(clock: SetClock) -> None:
    pace = RealTime(1.0, clock)
    begin(pace, clock, [0.0, 0.4, 0.5])
    assert (pace.world_s, pace.wall_s) == pytest.approx((0.2, 0.5))


def test_before_the_first_step_no_time_has_passed(clock: SetClock) -> None:
    pace = RealTime(1.0, clock)
    assert (pace.world_s, pace.wall_s) == (0.0, 0.0)


def test_the_worlds_clock_runs_on_between_steps(clock: SetClock) -> None:
    pace = RealTime(1.0, clock)
    begin(pace, clock, [0.0, 0.1])
    assert pace.at_ns(50.13) == pytest.approx(PERIOD_NS + 30_000_000, abs=10)
    assert pace.at_ns(50.05) == PERIOD_NS  # nothing happens in the past
