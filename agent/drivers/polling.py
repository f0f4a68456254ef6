"""Asking a motor controller for its encoders, again and again, and telling good answers from bad, late and missing ones."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable
from typing import NamedTuple

from agent.drivers.firmware import Firmware, Sample
from agent.drivers.serial_line import LineLost, SerialLine

GATHER_S = 0.001  # bytes come a few at a time: a moment after the first there are several to be read at once
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
        self._answer_bytes = 0  # of the last answer: the next one will be about as long
        self._whole_ns = 0  # when that can have come
        self._due_ns = self._good_ns = clock_ns()
        self._is_doubtful = False  # the next answer may be a late one
        self._remedy = b""

    def turn(self, units: tuple[int, int], timeout_s: float) -> Timed | None:
        """Ask when it is time, with both speeds once more, should they have been lost; sleep, and return what was answered meanwhile.

        Sleeps until the next request is due, or while its answer is on its way, and never for longer than it may: so whoever gives the
        speeds is asked once more just before they go out. Raises LineLost where good answers stay away.
        """
        if self._asked_ns is None and self._clock_ns() >= self._due_ns:
            self._ask(units)
        self._sleep(timeout_s)
        timed = self._take()
        self._give_up(self._clock_ns())
        return timed

    def _sleep(self, timeout_s: float) -> None:
        """Sleep until the next request is due, or until its answer can have come whole; then for as long as it has not."""
        rest_s = 1e-9 * ((self._due_ns if self._asked_ns is None else self._whole_ns) - self._clock_ns())
        if rest_s > 0.0:
            time.sleep(min(rest_s, timeout_s))
        elif self._asked_ns is not None and self._line.wait(timeout_s):
            time.sleep(GATHER_S)

    def _give_up(self, now_ns: int) -> None:
        """Wait no longer for an answer that is missing, nor for a line without good ones."""
        if self._asked_ns is not None and now_ns - self._asked_ns >= MISSING_NS:
            self._refused[MISSING] += 1
            self._doubt()
        if now_ns - self._good_ns >= LOST_NS:
            raise LineLost("gives no good answers any more" if self._line.exists() else "is gone")

    def _ask(self, units: tuple[int, int]) -> None:
        self._received = b""
        self._sent = self._remedy + self._firmware.command(*units) + self._firmware.request()
        self._asked_ns = self._clock_ns()
        self._due_ns = self._asked_ns + PERIOD_NS
        self._whole_ns = self._asked_ns + round(1e9 * (self._line.transfer_s(len(self._sent) + self._answer_bytes) + GATHER_S))
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
        self._answer_bytes = len(self._received)
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
