"""Where robots have lately been: nothing stands there, however the floor may look."""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from agent.control.borders import within
from protocol.geometry import Array

TRODDEN_S = 30.0  # for how long it tells: later somebody may have put something down
SPACING_M, SPACING_S = 0.01, 1.0  # between two places of one robot that are remembered
SURELY_M = 0.01  # within the body's edge: what a robot's place may be wrong by


class _Place(NamedTuple):
    stamp_ns: int
    centre_m: Array  # (2,) [odom]


class Trodden:
    """Remembers the places of robots' bodies, which are discs."""

    def __init__(self, radius_m: float) -> None:
        self._radius_m = radius_m - SURELY_M
        self._places: deque[_Place] = deque()
        self._last: dict[str, _Place] = {}

    def note(self, stamp_ns: int, centres_m: dict[str, Array]) -> None:
        """Take where robots are at a stamp, by name, (2,) [odom] each; stamps grow."""
        for robot, centre_m in centres_m.items():
            last = self._last.get(robot)
            if last is None or np.hypot(*(centre_m - last.centre_m)) >= SPACING_M or stamp_ns - last.stamp_ns >= 1e9 * SPACING_S:
                self._last[robot] = _Place(stamp_ns, centre_m)
                self._places.append(self._last[robot])
        while self._places and stamp_ns - self._places[0].stamp_ns > 1e9 * TRODDEN_S:
            self._places.popleft()

    def holds(self, points_m: Array) -> NDArray[np.bool_]:
        """Tell which of some points, (n, 2) [odom], lie where a robot has been."""
        return within(points_m, np.array([place.centre_m for place in self._places]).reshape(-1, 2), self._radius_m)
