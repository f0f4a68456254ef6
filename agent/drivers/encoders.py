"""From encoder counts, which wrap and may begin anew, to angles that never jump."""

from __future__ import annotations

import math
from typing import NamedTuple

from agent.drivers.firmware import Traits

_MARGIN = 2.0  # by which wheels that are pushed may outrun their motors
_SLACK_TICKS = 8


class _Reading(NamedTuple):
    ticks: tuple[int, int]
    at_ns: int


class Encoders:
    """Both wheels of one motor controller."""

    def __init__(self, traits: Traits, max_wheel_rad_s: float) -> None:
        self._span = 1 << traits.counter_bits
        self._rad_per_tick = 2.0 * math.pi / traits.ticks_per_revolution
        self._max_ticks_s = _MARGIN * max_wheel_rad_s / self._rad_per_tick
        self._turned = (0, 0)  # ticks, left and right, since the first reading
        self._last: _Reading | None = None
        self._odd: _Reading | None = None  # one that no wheel could have reached since the last
        self.jumps = 0  # times that the counts began anew
        self.garbled = 0  # readings that no wheel could have reached

    def begin_anew(self) -> None:
        """Have the next counts mean the angles at which the wheels were last known: nobody knows how they turned meanwhile."""
        self._last = self._odd = None

    def angles_rad(self, ticks: tuple[int, int], at_ns: int) -> tuple[float, float] | None:
        """Return the angles of the left and the right wheel [rad], cumulative, at a time of the monotonic clock.

        Counts that no wheel could have reached give none. Where the next ones agree with them, the controller has begun to count anew, as
        after a restart, and the angles go on from where they were.
        """
        reading = _Reading(ticks, at_ns)
        if self._last is not None and not self._is_reached(self._last, reading):
            self._doubt(reading)
            return None
        if self._last is not None:
            left, right = self._moved(self._last, reading)
            self._turned = (self._turned[0] + left, self._turned[1] + right)
        self._last, self._odd = reading, None
        return self._rad_per_tick * self._turned[0], self._rad_per_tick * self._turned[1]

    def _doubt(self, reading: _Reading) -> None:
        if self._odd is not None and self._is_reached(self._odd, reading):
            self.jumps += 1
            self._last, self._odd = reading, None
        else:
            self.garbled += 1
            self._odd = reading

    def _is_reached(self, before: _Reading, after: _Reading) -> bool:
        most = self._max_ticks_s * 1e-9 * (after.at_ns - before.at_ns) + _SLACK_TICKS
        return all(abs(ticks) <= most for ticks in self._moved(before, after))

    def _moved(self, before: _Reading, after: _Reading) -> tuple[int, int]:
        """Return by how many ticks the wheels have turned, the short way round where a counter has wrapped."""
        return self._short_way(after.ticks[0] - before.ticks[0]), self._short_way(after.ticks[1] - before.ticks[1])

    def _short_way(self, ticks: int) -> int:
        half = self._span // 2
        return (ticks + half) % self._span - half
