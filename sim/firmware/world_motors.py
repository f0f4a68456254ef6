"""A board's motors where its wheels are in a simulated world: the world turns them, and a twin here tells how they turn at any moment.

The world tells of its wheels picture by picture, up to a picture's time late; a board reads its encoders whenever it is asked to. So the
wheels are reckoned from the commands by what the world's motors do, delay and lag, and drawn to what the world has told. Times are on one
monotonic clock [s].
"""

from __future__ import annotations

from bisect import bisect_right
from collections import deque
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from sim.world.drive import STILL, Drive, Turning, Wheels, turned

_KEPT_S = 2.0  # no world tells of its wheels later
_DRAW = 0.3  # part of an error that one telling takes away: the world's encoders tell whole ticks


class _Stretch(NamedTuple):
    """A while under one command."""

    from_s: float
    turning: Turning  # at its beginning
    command: Wheels


class WorldMotors:
    """Hands commands on to the world by `send`, when they change."""

    def __init__(self, drive: Drive, command_delay_s: float, send: Callable[[Wheels], None], now_s: float) -> None:
        self._drive, self._delay_s, self._send = drive, command_delay_s, send
        self._sent = STILL
        self._stretches = deque([_Stretch(now_s, Turning(STILL, STILL), STILL)])
        self._correction = STILL  # [rad]: what the twin's angles lack

    def command(self, speeds_rad_s: Wheels, now_s: float) -> None:
        """Turn both wheels at these speeds from now on."""
        if speeds_rad_s == self._sent:
            return
        self._sent = speeds_rad_s
        self._send(speeds_rad_s)
        from_s = now_s + self._delay_s
        self._stretches.append(_Stretch(from_s, self._reckoned(from_s), speeds_rad_s))
        while len(self._stretches) > 1 and self._stretches[1].from_s < now_s - _KEPT_S:
            self._stretches.popleft()

    def turning(self, now_s: float) -> Turning:
        """Return how the wheels turn now."""
        speeds, angles = self._reckoned(now_s)
        return Turning(speeds, Wheels(angles.left + self._correction.left, angles.right + self._correction.right))

    def told(self, at_s: float, angles_rad: Wheels) -> None:
        """Take note of the angles that the world's encoders told for a moment."""
        reckoned = self.turning(at_s).angles_rad
        error = np.subtract(angles_rad, reckoned) * _DRAW
        self._correction = Wheels(*(np.add(self._correction, error)).tolist())

    def _reckoned(self, at_s: float) -> Turning:
        index = max(0, bisect_right(self._stretches, at_s, key=lambda stretch: stretch.from_s) - 1)
        stretch = self._stretches[index]
        return turned(self._drive, stretch.turning, stretch.command, max(0.0, at_s - stretch.from_s))
