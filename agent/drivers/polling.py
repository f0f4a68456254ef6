"""Asking a motor controller for its encoders, again and again, and telling good answers from bad, late and missing ones."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable
from typing import NamedTuple

from agent.drivers.firmware import Firmware, Sample
from agent.drivers.serial_line import LineLost, SerialLine

PERIOD_NS = 18_000_000  # between two requests: with what a turn costs besides, a cycle stays below 20 ms
SLOW_NS = 50_000_000  # an answer that takes longer does not tell well enough when the wheels were there
MISSING_NS = 100_000_000  # an answer that takes longer is not waited for
QUIET_NS = 20_000_000  # that a line has to be silent after a missing answer, so that no late one is taken for the next
LOST_NS = 500_000_000  # without a good answer the line is lost

MISSING = "answer: missing"
SLOW = "answer: slow"
UNASKED = "answer: not asked for"


class Timed(NamedTuple):
    """A sample, and when it was taken: in the middle between request and answer."""

    sample: Sample
    at_ns: int  # on the monotonic clock


class Polling:
    """One conversation with a controller that is known to be there; `refused` counts what was no good answer, by reason."""

    def __init__(
        self, line: SerialLine, firmware: Firmware, refused: Counter[str], clock_ns: Callable[[], int] = time.monotonic_ns
    ) -> None:
        self._line, self._firmware, self._refused, self._clock_ns = line, firmware, refused, clock_ns
        self._sent, self._received = b"", b""
        self._asked_ns: int | None = None  # when the request was sent whose answer is waited for
        self._due_ns = self._good_ns = clock_ns()
        self._is_doubtful = False  # the next answer may be a late one
        self._remedy = b""

    def wait_ns(self) -> int:
        """Return after how long something is due, should nothing come before."""
        due_ns = self._due_ns if self._asked_ns is None else self._asked_ns + MISSING_NS
        return max(due_ns - self._clock_ns(), 0)

    def turn(self, units: tuple[int, int]) -> Timed | None:
        """Take what has come and ask when it is time, with both speeds once more, should they have been lost; return what was answered.

        Raises LineLost where good answers stay away.
        """
        timed = self._take()
        now_ns = self._clock_ns()
        if self._asked_ns is not None and now_ns - self._asked_ns >= MISSING_NS:
            self._refused[MISSING] += 1
            self._doubt()
        if now_ns - self._good_ns >= LOST_NS:
            raise LineLost("gives no good answers any more" if self._line.exists() else "is gone")
        if self._asked_ns is None and now_ns >= self._due_ns:
            self._ask(units)
        return timed

    def command(self, units: tuple[int, int]) -> None:
        """Send both speeds at once, or, where an answer is waited for, right after it."""
        if self._is_doubtful:
            return  # an answer went missing: the line has to come to rest first
        self._due_ns = self._clock_ns()
        if self._asked_ns is None:
            self._ask(units)

    def _ask(self, units: tuple[int, int]) -> None:
        self._received = b""
        self._sent = self._remedy + self._firmware.command(*units) + self._firmware.request()
        self._asked_ns = self._clock_ns()
        self._due_ns = self._asked_ns + PERIOD_NS
        self._line.send(self._sent)

    def _take(self) -> Timed | None:
        self._received += self._line.receive()
        if not self._received:
            return None
        if self._asked_ns is None:
            self._drop_unasked()
            return None
        answer = self._firmware.answer(self._sent, self._received)
        if answer.sample is None and not answer.is_over:
            return None
        self._refused.update(answer.refused)
        asked_ns, self._asked_ns, self._received = self._asked_ns, None, b""
        return None if answer.sample is None else self._judged(answer.sample, asked_ns, self._clock_ns())

    def _drop_unasked(self) -> None:
        """Drop what nobody asked for, which may be a late answer: then wait until no more of it comes."""
        if self._received.replace(self._firmware.traits.acknowledgement, b"").strip():  # a line's last byte may come late
            self._refused[UNASKED] += 1
            self._due_ns = max(self._due_ns, self._clock_ns() + QUIET_NS)
        self._received = b""

    def _judged(self, sample: Sample, asked_ns: int, answered_ns: int) -> Timed | None:
        """Return a sample whose moment is known, and refuse any other."""
        if self._is_doubtful:
            self._is_doubtful = False
            self._refused[UNASKED] += 1
            self._due_ns = answered_ns + QUIET_NS
            return None
        if answered_ns - asked_ns > SLOW_NS:
            self._refused[SLOW] += 1
            return None
        self._good_ns, self._remedy = answered_ns, sample.remedy
        return Timed(sample, (asked_ns + answered_ns) // 2)

    def _doubt(self) -> None:
        """Give an answer up, and let both sides come to rest."""
        self._asked_ns, self._received, self._is_doubtful = None, b"", True
        self._due_ns = self._clock_ns() + QUIET_NS
        self._line.send(self._firmware.resync())
