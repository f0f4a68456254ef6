"""How maps of the server's clock follow each other."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agent.clocks.clock_discipline import ClockDiscipline
from agent.clocks.clock_map import ClockMap

SECOND_NS = 1_000_000_000
START_NS = 1_700_000_000 * SECOND_NS
PERIOD_NS = 100_000_000


def line(local_ns: int, off_s: float = 0.0) -> ClockMap:
    return ClockMap(local_ns=local_ns, server_ns=START_NS + local_ns + round(1e9 * off_s), rate=1.0, sigma_s=1e-4)


def test_the_first_line_is_the_map() -> None:
    assert ClockDiscipline().follow(line(5)) == line(5)


@pytest.mark.parametrize("off_s", [0.005, -0.005, 0.015, -0.015])
def test_what_is_known_better_is_drawn_in_within_seconds_and_no_stamp_goes_back(off_s: float) -> None:
    discipline = ClockDiscipline()
    clock_map = discipline.follow(line(0))
    last_ns = clock_map.server_ns
    for local_ns in range(PERIOD_NS, 5 * SECOND_NS, PERIOD_NS):
        passed_ns = clock_map.stamp_ns(local_ns) - last_ns
        assert passed_ns == pytest.approx(PERIOD_NS, rel=0.0101)
        last_ns += passed_ns
        clock_map = discipline.follow(line(local_ns, off_s))
        assert clock_map.server_ns == last_ns
    assert abs(line(local_ns, off_s).server_ns - last_ns) < 1e5


def test_while_it_is_drawn_in_the_map_is_that_uncertain() -> None:
    discipline = ClockDiscipline()
    discipline.follow(line(0))
    assert discipline.follow(line(PERIOD_NS, 0.01)).sigma_s == pytest.approx(0.0101)


@given(st.floats(0.03, 1e6), st.booleans())
def test_a_leap_is_made_good_at_once(leap_s: float, back: bool) -> None:
    discipline = ClockDiscipline()
    discipline.follow(line(0))
    leapt = line(PERIOD_NS, -leap_s if back else leap_s)
    assert discipline.follow(leapt) == leapt
