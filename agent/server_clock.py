"""The map server's clock, as the agent knows it: by asking for it now and then, or, in a world of its own time, by what it hears."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from typing import Protocol

from agent.clock_map import ClockMap
from agent.local_clock import LocalClock
from protocol.answers import Answer
from protocol.messages import ClockReading
from protocol.topics import SERVER_CLOCK, Query

ASK_S = 2.0  # between two questions
HASTE_S = 0.2  # the same, while there is no answer
START_S = 0.5  # the longest wait for the first answer
_KEPT = 8  # readings: clocks drift apart by less than a millisecond in that time


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

    On the wall clock the server is taken to have read what it said half-way between question and answer; the quickest of its last answers
    counts. World time stands between two stamps, so there the newest stamp heard is what the clock reads.
    """

    def __init__(self, bus: Asking, local: LocalClock, clock_s: Callable[[], float] = time.monotonic) -> None:
        self._bus, self._local, self._clock_s = bus, local, clock_s
        self._answers: Answering | None = None
        self._asked_s = -ASK_S
        self._readings: deque[Answer[ClockReading]] = deque(maxlen=_KEPT)
        self._heard_ns = 0
        self._is_outdated = False

    def start(self) -> None:
        """Ask for the first time, and wait for the answer, so that the first setpoint can be judged."""
        asked_s = self._clock_s()
        for reading in self._bus.ask(SERVER_CLOCK, START_S):
            self.note(Answer(reading, asked_s, self._clock_s()))

    def turn(self) -> None:
        """Take answers, and ask again when it is time."""
        for answer in [] if self._answers is None else self._answers.take():
            self.note(answer)
        if self._clock_s() - self._asked_s >= (ASK_S if self._readings else HASTE_S):
            self._asked_s, self._answers = self._clock_s(), self._bus.inquire(SERVER_CLOCK)

    def note(self, answer: Answer[ClockReading]) -> None:
        """Take one answer. A server whose clock runs otherwise is another server, and what was known of the last one is forgotten."""
        if self._is_outdated or (self._readings and self._readings[-1].message.runs != answer.message.runs):
            self._readings.clear()
            self._is_outdated = False
        self._readings.append(answer)
        self.hear(answer.message.stamp_ns)

    def hear(self, stamp_ns: int) -> None:
        """Take note that a stamp has been."""
        self._heard_ns = max(self._heard_ns, stamp_ns)

    def renew(self) -> None:
        """Ask anew, since the server is another one; what the last one said holds until then."""
        self._is_outdated, self._asked_s = True, -ASK_S

    @property
    def is_known(self) -> bool:
        """Whether the server has said what its clock reads."""
        return bool(self._readings)

    def now_ns(self) -> int | None:
        """Return what the server's clock reads; None as long as the server has not said."""
        if self._readings and self._readings[-1].message.runs == "world":
            return self._heard_ns
        now = self.clock_map()
        return None if now is None else now.stamp_ns(self._local_ns(self._clock_s()))

    def clock_map(self) -> ClockMap | None:
        """Return by what to stamp; None as long as the server has not said, and in a world's clock."""
        if not self._readings or self._readings[-1].message.runs == "world":
            return None
        quickest = min(self._readings, key=lambda answer: answer.arrived_s - answer.asked_s)
        round_trip_s = quickest.arrived_s - quickest.asked_s
        now_ns = self._local_ns(self._clock_s())
        passed_ns = now_ns - self._local_ns(quickest.asked_s + 0.5 * round_trip_s)
        return ClockMap(local_ns=now_ns, server_ns=quickest.message.stamp_ns + passed_ns, rate=1.0, sigma_s=0.5 * round_trip_s)

    def _local_ns(self, monotonic_s: float) -> int:
        return self._local.at_ns(round(1e9 * monotonic_s))
