"""Keeping a played world to its recorded time."""

from __future__ import annotations

import math
import time
from collections.abc import Callable


class Pace:
    """Holds every step back until its recorded time has come; where the listeners are slower, the world waits for them.

    `rate` is world time over real time: 1.0 is the recorded pace, `math.inf` as fast as it goes. Real time is the monotonic clock.
    """

    def __init__(self, rate: float, clock: Callable[[], float] = time.monotonic, sleep: Callable[[float], None] = time.sleep) -> None:
        if not rate > 0.0:
            raise ValueError(f"a rate of {rate} would never play")
        self._rate = rate
        self._clock = clock
        self._sleep = sleep
        self._origin: tuple[int, float] | None = None  # first stamp [ns], when it was due [s; clock]
        self.lag_s = 0.0  # how far the last step was behind its time; always 0 for an infinite rate
        self.worst_lag_s = 0.0

    def hold(self, stamp_ns: int) -> None:
        """Return when the step with this stamp is due; the first step is due at once. A late step is not held, and its lag is noted."""
        if math.isinf(self._rate):
            return
        if self._origin is None:
            self._origin = (stamp_ns, self._clock())
        first_ns, started_s = self._origin
        ahead_s = started_s + (stamp_ns - first_ns) / 1e9 / self._rate - self._clock()
        self.lag_s = max(0.0, -ahead_s)
        self.worst_lag_s = max(self.worst_lag_s, self.lag_s)
        if ahead_s > 0.0:
            self._sleep(ahead_s)

    def report(self) -> str:
        """Say in one line how well recorded time was kept."""
        if math.isinf(self._rate):
            return "played as fast as it goes"
        return f"played at {self._rate:g} x recorded time, at worst {self.worst_lag_s:.2f} s late, {self.lag_s:.2f} s at the end"
