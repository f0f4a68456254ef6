"""One broadcast of setpoints for all robots, and its repetition while nothing new is to be said."""

from __future__ import annotations

import time
from collections.abc import Callable

from mapserver.formation.controller import Orders
from mapserver.leading import said
from protocol.bus import Bus
from protocol.topics import FORMATION, SETPOINTS

PERIOD_S = 0.1  # on the monotonic clock


class Broadcast:
    """Sends orders under growing numbers; `repeat` says the last ones again, with the stamp and validity that they had."""

    def __init__(self, bus: Bus, epoch: int, clock_s: Callable[[], float] = time.monotonic) -> None:
        """Open both topics; `epoch` grows with every start of the map server."""
        self._setpoints, self._states = bus.publisher(SETPOINTS), bus.publisher(FORMATION)
        self._epoch, self._clock_s = epoch, clock_s
        self._seq = 0
        self._last: tuple[Orders, int] | None = None
        self._sent_s = 0.0

    def send(self, orders: Orders, stamp_ns: int) -> None:
        """Say something new."""
        self._last = orders, stamp_ns
        message = said(orders, self._epoch, self._seq, stamp_ns)
        self._setpoints.put(message.setpoints)
        self._states.put(message.state)
        self._seq += 1
        self._sent_s = self._clock_s()

    def repeat(self) -> None:
        """Say the last thing again, where it is time to."""
        if self._last is not None and self._clock_s() - self._sent_s >= PERIOD_S:
            self.send(*self._last)

    def hold(self, reason: str) -> None:
        """Take all setpoints back at once."""
        if self._last is not None:
            self.send(Orders({}, "waiting", reason), self._last[1])
