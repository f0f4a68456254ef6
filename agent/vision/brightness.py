"""Whether there is light enough: pictures that are not black, and yet too dark for a floor's texture to be told from noise."""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import NDArray

LOOKS = 10  # that have to agree
BRIGHT_PERCENTILE = 95.0  # the brightest things, but for lamps
LEAST_LEVEL = 50.0  # of 255
_STRIDE = 8

TOO_DARK = "camera: too dark: more light, or a longer exposure_s and more gain"


def brightness(picture: NDArray[np.uint8]) -> float:
    """Return the level of the brightest things in a picture, (rows, cols, ...), but for lamps."""
    return float(np.percentile(picture[::_STRIDE, ::_STRIDE], BRIGHT_PERCENTILE))


class Brightness:
    """Watches the brightest parts of one camera's pictures."""

    def __init__(self) -> None:
        self._levels: deque[float] = deque(maxlen=LOOKS)

    def look(self, picture: NDArray[np.uint8]) -> None:
        """Take a picture, (rows, cols, ...)."""
        self._levels.append(brightness(picture))

    @property
    def complaint(self) -> str:
        """One line with the remedy where it is too dark; empty where it is not."""
        return TOO_DARK if len(self._levels) == LOOKS and max(self._levels) < LEAST_LEVEL else ""
