"""The clock in which all stamps on the wire are: by itself on a real swarm, from one announced stamp to the next in a world."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Literal

from protocol.messages import ClockReading

WALL_PERIOD_NS = 100_000_000  # of the formation: on the wall clock, batches come robot by robot


def steady_wall_clock() -> Callable[[], int]:
    """Return a clock that reads what the wall clock does now, and goes on by itself: no date that is set later makes stamps leap."""
    ahead_ns = time.time_ns() - time.monotonic_ns()
    return lambda: ahead_ns + time.monotonic_ns()


class ServerTime:
    """How far the stamps are, and whether the formation is due for a step."""

    def __init__(self, runs: Literal["wall", "world"], wall_ns: Callable[[], int]) -> None:
        """Read `wall_ns` where the clock runs by itself [ns since 1970]."""
        self._runs, self._wall_ns = runs, wall_ns
        self._stamp_ns = 0
        self._stepped_ns: int | None = None

    def reached(self, stamp_ns: int) -> None:
        """Take note of a batch that was merged."""
        self._stamp_ns = stamp_ns

    def is_step_due(self) -> bool:
        """Tell, once, whether the formation has its next step at this stamp: at each one in a world, else 0.1 s after the last."""
        is_due = self._runs == "world" or self._stepped_ns is None or self._stamp_ns - self._stepped_ns >= WALL_PERIOD_NS
        if is_due:
            self._stepped_ns = self._stamp_ns
        return is_due

    def reading(self, waited_s: float = 0.0) -> ClockReading:
        """Return what the clock says to a question that has waited for so long."""
        stamp_ns = self._wall_ns() if self._runs == "wall" else self._stamp_ns
        return ClockReading(stamp_ns=stamp_ns, runs=self._runs, waited_s=waited_s)
