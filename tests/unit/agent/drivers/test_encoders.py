"""Angles from encoder counts that wrap, begin anew, or were read wrongly."""

from __future__ import annotations

import math

import pytest

from agent.drivers.encoders import Encoders
from agent.drivers.firmware import Traits

TICKS = 1000.0  # a revolution
CYCLE_NS = 20_000_000


def encoders(bits: int) -> Encoders:
    traits = Traits("board", TICKS, bits, unit_rad_s=0.1, max_units=100, stops_by_itself_s=None)
    return Encoders(traits, max_wheel_rad_s=12.0)  # 38 ticks in 20 ms


def turns(read: Encoders, counts: list[tuple[int, int]]) -> list[tuple[float, float] | None]:
    """Return the angles, in ticks, of counts read every 20 ms."""
    angles = [read.angles_rad(ticks, number * CYCLE_NS) for number, ticks in enumerate(counts)]
    return [None if each is None else (each[0] * TICKS / math.tau, each[1] * TICKS / math.tau) for each in angles]


def test_angles_begin_at_zero_wherever_the_counts_begin() -> None:
    assert turns(encoders(32), [(5000, -70), (5010, -75)]) == [(0.0, 0.0), pytest.approx((10.0, -5.0))]


@pytest.mark.parametrize("bits", [16, 32])
def test_angles_go_on_where_the_counters_wrap(bits: int) -> None:
    top = 2 ** (bits - 1)
    counts = [(top - 10, 10 - top), (10 - top, top - 10), (top - 10, 10 - top)]
    assert turns(encoders(bits), counts) == [(0.0, 0.0), pytest.approx((20.0, -20.0)), pytest.approx((0.0, 0.0), abs=1e-9)]


def test_counts_that_begin_anew_leave_the_angles_where_they_were() -> None:
    read = encoders(32)
    assert turns(read, [(5000, 5000), (5010, 5010), (0, 0), (3, 3), (5, 5)])[1:] == [
        pytest.approx((10.0, 10.0)),
        None,
        None,
        pytest.approx((12.0, 12.0)),
    ]
    assert (read.jumps, read.garbled) == (1, 1)


def test_single_counts_that_no_wheel_could_have_reached_are_dropped() -> None:
    read = encoders(32)
    assert turns(read, [(5000, 5000), (500, 5010), (5020, 5020)])[1:] == [None, pytest.approx((20.0, 20.0))]
    assert (read.jumps, read.garbled) == (0, 1)


def test_what_wheels_did_while_the_line_was_lost_is_not_told() -> None:
    read = encoders(32)
    read.angles_rad((5000, 5000), 0)
    read.angles_rad((5010, 5010), CYCLE_NS)
    read.begin_anew()
    assert read.angles_rad((5500, 5500), 50 * CYCLE_NS) == pytest.approx((10 * math.tau / TICKS, 10 * math.tau / TICKS))
