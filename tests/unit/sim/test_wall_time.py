"""A simulated world on the wall clock, whose time the test sets."""

from __future__ import annotations

import pytest

from sim.wall_time import WallTime
from tests.set_clock import SetClock

START_NS, PERIOD_NS = 1_700_000_000_000_000_000, 100_000_000


@pytest.fixture
def clock() -> SetClock:
    return SetClock(50.0)


@pytest.fixture
def pace(clock: SetClock) -> WallTime:
    return WallTime(clock, lambda: START_NS)


def test_steps_are_due_when_the_wall_clock_shows_their_stamps(pace: WallTime) -> None:
    assert pace.start_ns == START_NS
    assert pace.due_s(START_NS) == 50.0
    assert pace.due_s(START_NS + PERIOD_NS) == pytest.approx(50.1)


def test_a_late_step_makes_no_later_one_late(pace: WallTime, clock: SetClock) -> None:
    clock.now_s = 53.0
    pace.began(START_NS + PERIOD_NS)
    assert pace.due_s(START_NS + 2 * PERIOD_NS) == pytest.approx(50.2)
    assert pace.world_s == pytest.approx(0.1)
    assert pace.wall_s == pytest.approx(3.0)


def test_pictures_are_shown_until_the_next_step_is_due_and_dropped_after(pace: WallTime, clock: SetClock) -> None:
    clock.now_s = 50.09
    assert pace.may_show(START_NS + PERIOD_NS)
    assert pace.late_steps == 0

    clock.now_s = 50.15
    assert not pace.may_show(START_NS + PERIOD_NS)
    assert pace.late_steps == 1
    assert pace.worst_late_s == pytest.approx(0.05)


def test_a_moment_has_the_stamp_that_the_wall_clock_showed_then(pace: WallTime) -> None:
    assert pace.at_ns(50.25) == START_NS + 250_000_000
