"""From a robot's own clock to the map server's: what the helm has found out, and what its other processes stamp by."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, FiniteFloat

from agent.clocks.local_clock import LocalClock
from protocol.fields import Message, StampNs
from protocol.messages import ClockOffset

FRESH_S = 0.9  # of own time to either side of a map: beyond it the own clock may have leapt, and nothing is stamped until the helm knows


class ClockMap(Message):
    """What the map server's clock reads at a time of the robot's own, how fast it runs by that, and how sure all this is."""

    local_ns: Annotated[int, Field(ge=-(2**63), lt=2**63)]
    server_ns: StampNs
    rate: Annotated[FiniteFloat, Field(gt=0.0)]  # server's seconds in one second of the own clock
    sigma_s: Annotated[FiniteFloat, Field(ge=0.0)]

    def stamp_ns(self, local_ns: int) -> int:
        """Return what the map server's clock reads at a time of the own one."""
        return self.server_ns + round(self.rate * (local_ns - self.local_ns))

    def offset(self) -> ClockOffset:
        """Return how far the map server's clock is ahead."""
        return ClockOffset(offset_s=1e-9 * (self.server_ns - self.local_ns), sigma_s=self.sigma_s)


class ServerStamps:
    """What drivers stamp by: holds the newest map of a robot's own clock, which the helm sends several times a second."""

    def __init__(self, clock: LocalClock) -> None:
        self._clock = clock
        self._map: ClockMap | None = None

    def learn(self, clock_map: ClockMap | None) -> None:
        """Take the newest map, None where the helm knows of none."""
        self._map = clock_map

    def stamp_ns(self, monotonic_ns: int) -> int | None:
        """Return a time of the machine's monotonic clock as a stamp in the map server's; None while that is not known."""
        local_ns = self._clock.at_ns(monotonic_ns)
        if self._map is None or abs(local_ns - self._map.local_ns) > FRESH_S * 1e9:
            return None
        return self._map.stamp_ns(local_ns)
