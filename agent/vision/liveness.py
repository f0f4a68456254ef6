"""Whether pictures still show the world: a camera that goes dark, or repeats its last picture, is told from one that sees."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from protocol.geometry import Array

DARK = "picture: dark"
FROZEN = "picture: frozen"

DARK_LEVEL = 12  # of 255: where hardly a pixel is brighter, nothing can be told from the floor
BRIGHT_SHARE = 0.01
TURNED_RAD = 0.1  # the wheels turned by so much (3 mm of way) show in every picture
_STRIDE = 4  # every fourth row and column tell as much as all


def is_dark(picture: NDArray[np.uint8]) -> bool:
    """Tell whether a picture, (rows, cols, 3), is black."""
    return bool(np.mean(picture > DARK_LEVEL) < BRIGHT_SHARE)


class Liveness:
    """Judges the pictures of one camera, one after the other."""

    def __init__(self) -> None:
        self._shown: NDArray[np.uint8] | None = None
        self._angles_rad = np.zeros(2)  # of the wheels, when the picture last changed
        self._frozen = False

    def fault(self, picture: NDArray[np.uint8], angles_rad: Array) -> str:
        """Return why a picture, (rows, cols, 3), taken with the wheels at (2,) [rad], shows nothing of the world; empty if it does.

        A picture repeated to the last bit is no fault while the wheels stand. Once they have turned it is one until the picture changes,
        also if they are stopped on that account.
        """
        shown = picture[::_STRIDE, ::_STRIDE]
        if self._shown is None or not np.array_equal(shown, self._shown):
            self._shown, self._angles_rad, self._frozen = shown.copy(), angles_rad, False
        elif np.abs(angles_rad - self._angles_rad).max() > TURNED_RAD:
            self._frozen = True
        if is_dark(shown):
            return DARK
        return FROZEN if self._frozen else ""
