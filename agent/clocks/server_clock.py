"""The map server's clock, as the helm knows it: by asking for it now and then, or, in a world of its own time, by what it hears."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from typing import Literal, Protocol

from agent.clocks.clock_discipline import ClockDiscipline
from agent.clocks.clock_filter import ClockFilter, Exchange
from agent.clocks.clock_map import ClockMap
from agent.clocks.local_clock import LocalClock
from protocol.answers import Answer
from protocol.messages import ClockReading
from protocol.topics import SERVER_CLOCK, Query

ASK_S = 2.0  # between two questions
HASTE_S = 0.2  # the same, until there are enough answers
START_S = 0.5  # the longest wait for the first answer
LEAP_S = 0.3  # a turn in which the own clock went on by more, or back, may have seen it leap
RENEW_S = 0.1  # how long a map stands before the next one goes on from it
_ENOUGH = 8  # answers: among so many one is quick

_log = logging.getLogger(__name__)


class Answering(Protocol):
    """Answers that come in their time."""

    def take(self) -> list[Answer[ClockReading]]:
        """Return those that have come."""
        ...


class Asking(Protocol):
    """What the clock needs of the bus."""

    def inquire(self, query: Query[ClockReading]) -> Answering:
        """Ask, and return at once."""
        ...

    def ask(self, query: Query[ClockReading], timeout_s: float) -> list[ClockReading]:
        """Ask, and return the answers that come in time, at once where nobody answers."""
        ...


class ServerClock:
    """Waits for nothing but its first answer.

    A clock on the wall is found by the own one, `local`, from when questions are asked and answered. Where that one may have leapt, what
    the server's reads is unknown until the next answer. World time stands between two stamps, so there the newest stamp heard is what the
    clock reads. `clock_s` is the machine's monotonic clock, by which it is asked.
    """

    def __init__(self, bus: Asking, local: LocalClock, clock_s: Callable[[], float] = time.monotonic) -> None:
        self._bus, self._local, self._clock_s = bus, local, clock_s
        self._answers: Answering | None = None
        self._asked_s = -ASK_S
        self._runs: Literal["wall", "world"] | None = None  # None: the server has not said
        self._heard_ns = 0
        self._turned_ns: int | None = None  # on the own clock
        self._filter, self._discipline = ClockFilter(), ClockDiscipline()
        self._map: ClockMap | None = None
        self._is_outdated = False  # the server is another one
        self.leaps = 0  # of the own clock or the server's, as far as seen

    @property
    def is_known(self) -> bool:
        """Whether it is known what the server's clock reads."""
        return self._runs == "world" or self._map is not None

    @property
    def clock_map(self) -> ClockMap | None:
        """By what to stamp; None as long as that is unknown, and in a world's clock."""
        return self._map

    def start(self) -> None:
        """Ask for the first time, and wait for the answer, so that the first setpoint can be judged."""
        asked_s = self._clock_s()
        for reading in self._bus.ask(SERVER_CLOCK, START_S):
            self.note(Answer(reading, asked_s, self._clock_s()))

    def turn(self) -> None:
        """Take answers, ask again when it is time, and go on with the map."""
        self._look_at_own_clock()
        for answer in [] if self._answers is None else self._answers.take():
            self.note(answer)
        if self._clock_s() - self._asked_s >= (HASTE_S if self._is_in_haste() else ASK_S):
            self._asked_s, self._answers = self._clock_s(), self._bus.inquire(SERVER_CLOCK)
        if self._map is not None and self._now_ns() - self._map.local_ns >= RENEW_S * 1e9:
            self._renew_map()

    def note(self, answer: Answer[ClockReading]) -> None:
        """Take one answer. A server whose clock runs otherwise is another server, and what was known of the last one is forgotten."""
        reading = answer.message
        if self._is_outdated or reading.runs != self._runs:
            self._forget()
            self._runs, self._is_outdated = reading.runs, False
        self.hear(reading.stamp_ns)
        if reading.runs == "wall":
            reached_s = answer.asked_s + reading.waited_s  # as if the question had been asked later, and answered at once
            self._measure(Exchange(self._local_ns(reached_s), reading.stamp_ns, self._local_ns(answer.arrived_s)))

    def hear(self, stamp_ns: int) -> None:
        """Take note that a stamp has been."""
        self._heard_ns = max(self._heard_ns, stamp_ns)

    def renew(self) -> None:
        """Ask anew, since the server is another one; what the last one said holds until then."""
        self._is_outdated, self._asked_s = True, -ASK_S

    def now_ns(self) -> int | None:
        """Return what the server's clock reads; None as long as that is unknown."""
        if self._runs == "world":
            return self._heard_ns
        return None if self._map is None else self._map.stamp_ns(self._now_ns())

    def _look_at_own_clock(self) -> None:
        """Doubt what is known where the own clock went on by more than a turn lasts, or back; answers that are under way count no more."""
        now_ns = self._now_ns()
        if self._map is not None and self._turned_ns is not None and not 0 <= now_ns - self._turned_ns <= LEAP_S * 1e9:
            self._map, self._answers, self._asked_s = None, None, -ASK_S
        self._turned_ns = now_ns

    def _measure(self, exchange: Exchange) -> None:
        if exchange.round_trip_s < 0.0:
            return  # the own clock has leapt back meanwhile
        if not self._filter.add(exchange):
            self.leaps += 1
            if self.leaps == 1:
                _log.warning("the map server's clock and the own one have leapt against each other (from now on this is only counted)")
        self._renew_map()

    def _renew_map(self) -> None:
        self._map = self._discipline.follow(self._filter.line(self._now_ns()))

    def _is_in_haste(self) -> bool:
        return self._runs is None or (self._runs == "wall" and (self._map is None or len(self._filter) < _ENOUGH))

    def _forget(self) -> None:
        self._filter, self._discipline, self._map = ClockFilter(), ClockDiscipline(), None

    def _now_ns(self) -> int:
        return self._local_ns(self._clock_s())

    def _local_ns(self, monotonic_s: float) -> int:
        return self._local.at_ns(round(1e9 * monotonic_s))
