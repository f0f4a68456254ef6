"""How the map server's clock goes by the robot's own, from questions and answers: a line through the quick ones.

The server read its clock somewhen between question and answer, so each exchange bounds what it can have read, however slow the link
(Cristian, "Probabilistic clock synchronization", Distributed Computing 3, 1989), and half-way is wrong by at most half of the round trip.
Like NTP's clock filter (RFC 5905, section 10), quick exchanges count for more: what an answer took longer than the quickest has waited in a
queue, on one side of the half-way mark. The line's slope is the drift, believed to be small until it shows.
"""

from __future__ import annotations

import math
from collections import deque
from typing import NamedTuple

import numpy as np

from agent.clocks.clock_map import ClockMap

_KEPT = 30  # exchanges: a minute, over which quartz hardly warms up
_FLOOR_S = 50e-6  # how sure the quickest exchange is, but for how unlike its two ways may be
_DRIFT = 2e-4  # of two clocks against each other, before anything is known: quartz is within 100 ppm
_WANDER = 1e-6  # by which the drift itself may have changed since an exchange
_UNLIKE_S = 1e-3  # by which an exchange may miss the line without contradicting it, besides what the line's own uncertainty allows
_SIGMAS = 4.0


class Exchange(NamedTuple):
    """When a question was asked and its answer came, on the own clock, and what the server's read in between."""

    asked_ns: int
    server_ns: int
    arrived_ns: int

    @property
    def round_trip_s(self) -> float:
        """How long it took."""
        return 1e-9 * (self.arrived_ns - self.asked_ns)

    @property
    def middle_ns(self) -> int:
        """Half-way."""
        return (self.asked_ns + self.arrived_ns) // 2


class ClockFilter:
    """Keeps the last exchanges between two clocks, neither of which has leapt since the first of them."""

    def __init__(self) -> None:
        self._kept: deque[Exchange] = deque(maxlen=_KEPT)

    def __len__(self) -> int:
        """Return how many exchanges are kept."""
        return len(self._kept)

    def add(self, exchange: Exchange) -> bool:
        """Take one exchange, and tell whether it follows from those before; where it cannot, a clock has leapt, and they are forgotten."""
        follows = not self._kept or self._follows(exchange)
        if not follows:
            self._kept.clear()
        self._kept.append(exchange)
        return follows

    def line(self, local_ns: int) -> ClockMap:
        """Return the best line at a time of the own clock, by weighted least squares. At least one exchange must be kept."""
        newest_ns = self._kept[-1].middle_ns
        start_ns = self._kept[-1].server_ns - newest_ns
        ages_s = np.array([1e-9 * (exchange.middle_ns - newest_ns) for exchange in self._kept])
        offsets_s = np.array([1e-9 * (exchange.server_ns - exchange.middle_ns - start_ns) for exchange in self._kept])
        round_trips_s = np.array([exchange.round_trip_s for exchange in self._kept])
        quickest_s = float(round_trips_s.min())
        sigmas_s = _FLOOR_S + 0.5 * (round_trips_s - quickest_s) + _WANDER * abs(ages_s)
        terms = np.stack([np.ones_like(ages_s), ages_s]) / sigmas_s  # (2, n)
        covariance = np.linalg.inv(terms @ terms.T + np.diag([0.0, _DRIFT**-2]))
        offset_s, drift = (covariance @ terms @ (offsets_s / sigmas_s)).tolist()
        ahead = np.array([1.0, 1e-9 * (local_ns - newest_ns)])
        return ClockMap(
            local_ns=local_ns,
            server_ns=local_ns + start_ns + round(1e9 * (offset_s + drift * float(ahead[1]))),
            rate=1.0 + drift,
            sigma_s=math.sqrt(ahead @ covariance @ ahead + quickest_s**2 / 12.0),  # the two ways may share the round trip in any way
        )

    def _follows(self, exchange: Exchange) -> bool:
        line = self.line(exchange.middle_ns)
        margin_ns = 1e9 * (_UNLIKE_S + _SIGMAS * line.sigma_s)
        return line.stamp_ns(exchange.asked_ns) - margin_ns <= exchange.server_ns <= line.stamp_ns(exchange.arrived_ns) + margin_ns
