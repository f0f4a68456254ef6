"""A map of the server's clock that goes on from the last one: what is known better now is drawn in slowly, and only a leap makes it leap.

Stamps made by one such map after the other grow as the own clock does, so nobody sees an interval of no length, or a negative one.
"""

from __future__ import annotations

from agent.clocks.clock_map import ClockMap

_LEAP_S = 0.02  # what the map is off by more than this it makes good at once
_DRAWN_IN_S = 0.5  # what it is off by less, in about this time
_MOST_SLEW = 0.01  # of the rate, meanwhile: a speed taken between two stamps is wrong by so much at most


class ClockDiscipline:
    """Follows one line after the other."""

    def __init__(self) -> None:
        self._map: ClockMap | None = None

    def follow(self, line: ClockMap) -> ClockMap:
        """Return the map from the line's own time on."""
        if self._map is None:
            self._map = line
            return line
        held_ns = self._map.stamp_ns(line.local_ns)
        off_s = 1e-9 * (line.server_ns - held_ns)
        if abs(off_s) > _LEAP_S:
            self._map = line
        else:
            slew = max(-_MOST_SLEW, min(off_s / _DRAWN_IN_S, _MOST_SLEW))
            self._map = ClockMap(local_ns=line.local_ns, server_ns=held_ns, rate=line.rate + slew, sigma_s=line.sigma_s + abs(off_s))
        return self._map
