"""Whether lens and camera sit where they did: the own rim stays where it is in the picture, until something is knocked."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from agent.vision.own_rim import OwnRim, RimShift
from protocol.geometry import Array

PICTURES = 8  # averaged into one look
MOVED_RAD = 0.01  # as seen from the lens: 1.5 px of a 640 x 480 picture, ten sigma of a look, 5 mm on the floor half a metre away
AGREEING = 2  # looks in a row

MOVED_LENS = "camera: the lens has moved since the start: see that tube and lens sit tight, then calibrate the rig again"


class LensSeat:
    """Looks at the rim again and again."""

    def __init__(self, deck_px: Array, rim_px: Array, focal_px: float) -> None:
        """Take where deck and rim should be, as `OwnRim` does."""
        self._circles, self._limit_px = (deck_px, rim_px), MOVED_RAD * focal_px
        self._rim, self._pictures = OwnRim(*self._circles), 0
        self._first: RimShift | None = None
        self._moved = 0

    def look(self, grey: NDArray[np.uint8]) -> None:
        """Take one more picture, (rows, cols) grey."""
        self._rim.add(grey)
        self._pictures += 1
        if self._pictures == PICTURES:
            self._judge(self._rim.shift())
            self._rim, self._pictures = OwnRim(*self._circles), 0

    @property
    def complaint(self) -> str:
        """One line with the remedy where the lens has moved; empty where it has not, or no rim was ever seen."""
        return MOVED_LENS if self._moved >= AGREEING else ""

    def _judge(self, shift: RimShift | None) -> None:
        if self._first is None:
            self._first = shift
        elif shift is not None:
            off_px = max(float(np.hypot(*(shift.centre_px - self._first.centre_px))), abs(shift.radius_px - self._first.radius_px))
            self._moved = self._moved + 1 if off_px > self._limit_px else 0
