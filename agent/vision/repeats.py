"""Pictures that a camera delivers twice: to the last bit the same as the one before, which no light that falls on a sensor ever is."""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import NDArray

REPEATED = "picture: same as the one before"

_STRIDE = 4  # every fourth row and column tell as much as all
_KEPT = 50  # pictures
_SHARE = 0.1  # of those: fewer are a hiccup ...
_STUCK_SHARE = 0.9  # ... and so many are no matter of the rate


class Repeats:
    """Compares each picture of one camera with the one before."""

    def __init__(self) -> None:
        self._shown: NDArray[np.uint8] | None = None
        self._repeated: deque[bool] = deque(maxlen=_KEPT)

    def look(self, picture: NDArray[np.uint8]) -> bool:
        """Tell whether a picture, (rows, cols, 3), is the one before once more."""
        shown = picture[::_STRIDE, ::_STRIDE]
        is_repeated = self._shown is not None and np.array_equal(shown, self._shown)
        self._shown = shown.copy()
        self._repeated.append(is_repeated)
        return is_repeated

    @property
    def complaint(self) -> str:
        """What is to be said of the last pictures, in one line with the remedy; empty where they differ."""
        count = sum(self._repeated)
        if count <= _SHARE * _KEPT:
            return ""
        remedy = "pull its plug and put it in again"
        if count < _STUCK_SHARE * len(self._repeated):
            remedy = f"lower rate_hz, or {remedy}"
        return f"camera: {count} of the last {len(self._repeated)} pictures were the same as the one before: {remedy}"
