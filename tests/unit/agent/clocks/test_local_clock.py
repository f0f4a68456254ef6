"""What a robot's own clock reads, and how it is written on a command line."""

from __future__ import annotations

import time

import pytest

from agent.clocks.local_clock import LocalClock, parse_clock
from protocol.errors import ConfigError

SECOND_NS = 1_000_000_000


def test_without_numbers_it_is_the_machines_monotonic_clock() -> None:
    assert parse_clock("") == LocalClock()
    assert LocalClock().at_ns(123_456_789_012_345) == 123_456_789_012_345


def test_a_bad_clock_is_off_drifts_and_leaps_once() -> None:
    clock = LocalClock(offset_s=10.0, drift_ppm=100.0, step_s=-1.0, step_at_s=20.0, since_s=1000.0)
    assert clock.at_ns(1000 * SECOND_NS) == 1010 * SECOND_NS
    assert clock.at_ns(1010 * SECOND_NS) == 1020 * SECOND_NS + 1_000_000
    assert clock.at_ns(1020 * SECOND_NS) == 1029 * SECOND_NS + 2_000_000


def test_it_begins_to_drift_when_it_is_named() -> None:
    before_s = time.monotonic()
    clock = parse_clock("offset_s=10, drift_ppm=100,step_s=1,step_at_s=20")
    assert before_s <= clock.since_s <= time.monotonic()
    assert (clock.offset_s, clock.drift_ppm, clock.step_s, clock.step_at_s) == (10.0, 100.0, 1.0, 20.0)


def test_another_process_reads_the_same_clock() -> None:
    clock = parse_clock("offset_s=0.1,drift_ppm=33.3")
    assert parse_clock(clock.argument()) == clock
    assert LocalClock().argument() == ""


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("ofset_s=1", "--clock: unknown key `ofset_s`; did you mean `offset_s`?"),
        ("offset_s", "--clock: 'offset_s' is not of the form KEY=NUMBER"),
        ("offset_s=far", "--clock: 'offset_s=far' is not of the form KEY=NUMBER"),
        ("drift_ppm=1e9", "--clock: `drift_ppm`: Input should be less than or equal to 10000, not 1000000000.0"),
        ("offset_s=nan", "--clock: `offset_s`: Input should be a finite number, not nan"),
    ],
)
def test_what_is_no_clock_is_named_in_one_line(text: str, complaint: str) -> None:
    with pytest.raises(ConfigError) as refused:
        parse_clock(text)
    assert str(refused.value) == complaint
