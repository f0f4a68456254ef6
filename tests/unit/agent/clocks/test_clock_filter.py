"""How well the map server's clock is known from questions and answers over links of all kinds."""

from __future__ import annotations

import random

from hypothesis import given, settings
from hypothesis import strategies as st

from agent.clocks.clock_filter import ClockFilter, Exchange

SECOND_NS = 1_000_000_000
SERVER_NS = 1_700_000_000 * SECOND_NS
ASK_S = 2.0
drifts_ppm = st.floats(-200.0, 200.0)
seeds = st.integers(0, 2**32)


class Link:
    """Two clocks, and a way between them that takes some time, and often more. True time is the robot's own."""

    def __init__(self, seed: int, drift_ppm: float = 0.0, way_s: float = 0.001, queue_s: float = 0.0) -> None:
        self._random = random.Random(seed)
        self._drift_ppm, self._way_s, self._queue_s = drift_ppm, way_s, queue_s
        self.leap_s = 0.0

    def server_ns(self, own_s: float) -> int:
        """Return what the server's clock truly reads at a time of the own one."""
        return SERVER_NS + round(1e9 * (own_s * (1.0 + 1e-6 * self._drift_ppm) + self.leap_s))

    def ask(self, own_s: float, least_queue_s: float = 0.0) -> Exchange:
        """Ask the server, which is busy now and then, so that questions wait there."""
        queue_s = max(least_queue_s, self._random.choice((0.0, 1.0, 1.0)) * self._random.expovariate(1.0) * self._queue_s)
        read_s = own_s + self._way_s + queue_s
        return Exchange(round(1e9 * own_s), self.server_ns(read_s), round(1e9 * (read_s + self._way_s)))


def error_s(known: ClockFilter, link: Link, own_s: float) -> float:
    """Return by how much a stamp of this moment would be wrong."""
    own_ns = round(1e9 * own_s)
    return 1e-9 * (known.line(own_ns).stamp_ns(own_ns) - link.server_ns(own_s))


def asked(link: Link, count: int, start_s: float = 100.0) -> tuple[ClockFilter, float]:
    """Return what is known after some questions, and when the next one is due."""
    known = ClockFilter()
    for number in range(count):
        assert known.add(link.ask(start_s + ASK_S * number))
    return known, start_s + ASK_S * count


def test_the_server_is_taken_to_have_read_its_clock_half_way() -> None:
    known = ClockFilter()
    known.add(Exchange(90 * SECOND_NS, SERVER_NS, 91 * SECOND_NS))
    line = known.line(100 * SECOND_NS)
    assert (line.server_ns, line.rate) == (SERVER_NS + 9_500_000_000, 1.0)
    assert 0.25 < line.sigma_s < 0.5


@settings(max_examples=40, deadline=None)
@given(seeds, drifts_ppm)
def test_drift_of_any_quartz_costs_little_between_two_questions(seed: int, drift_ppm: float) -> None:
    link = Link(seed, drift_ppm)
    known, next_s = asked(link, 10)
    assert abs(error_s(known, link, next_s)) < 1e-4


@settings(max_examples=40, deadline=None)
@given(seeds, drifts_ppm, st.floats(0.0, 0.05))
def test_answers_that_waited_in_a_queue_hardly_count(seed: int, drift_ppm: float, queue_s: float) -> None:
    link = Link(seed, drift_ppm, queue_s=queue_s)
    known, next_s = asked(link, 30)
    assert abs(error_s(known, link, next_s)) < 1.5e-3


@settings(max_examples=40, deadline=None)
@given(seeds, st.floats(0.0, 0.02))
def test_what_is_not_known_of_the_ways_is_told_as_uncertainty(seed: int, extra_s: float) -> None:
    link = Link(seed)
    known = ClockFilter()
    for number in range(10):
        known.add(link.ask(100.0 + ASK_S * number, least_queue_s=extra_s))  # on every way there, and on none back
    line = known.line(118 * SECOND_NS)
    assert abs(error_s(known, link, 118.0)) < 4.0 * line.sigma_s


@settings(max_examples=40, deadline=None)
@given(seeds, drifts_ppm, st.floats(0.01, 1e6), st.booleans(), st.floats(0.0, 0.005))
def test_a_leap_of_either_clock_is_seen_in_the_first_answer(seed: int, drift_ppm: float, leap_s: float, back: bool, queue_s: float) -> None:
    link = Link(seed, drift_ppm)
    known, next_s = asked(link, 10)
    link.leap_s = -leap_s if back else leap_s
    assert not known.add(link.ask(next_s, least_queue_s=queue_s))
    assert len(known) == 1
    assert abs(error_s(known, link, next_s)) < 0.5 * queue_s + 1e-3


@settings(max_examples=40, deadline=None)
@given(seeds, drifts_ppm, st.floats(0.0, 5.0))
def test_no_answer_is_so_slow_that_it_looks_like_a_leap(seed: int, drift_ppm: float, queue_s: float) -> None:
    link = Link(seed, drift_ppm)
    known, next_s = asked(link, 10)
    assert known.add(link.ask(next_s, least_queue_s=queue_s))
    assert abs(error_s(known, link, next_s)) < 2e-4


def test_uncertainty_grows_while_nobody_answers() -> None:
    known, next_s = asked(Link(1), 10)
    soon, late = (known.line(round(1e9 * (next_s + wait_s))).sigma_s for wait_s in (0.0, 600.0))
    assert late > 2.0 * soon
