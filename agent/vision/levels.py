"""Pictures of little contrast, spread over the grey levels that all else counts on: a veil on the lens, a flat tone curve, little light.

The own body is always in sight, and dark, and so is some floor: what lies between the darkest and the lightest that is seen of them tells
the contrast of the picture, not of what happens to stand around.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from agent.vision.floor_view import FloorView, Picture
from agent.vision.robust import quantiles, robust_sigma

EVERY_PX = 8  # of the reduced picture, in either direction, tells the levels
SHARE = 0.01  # of what is seen, that is darker than the darkest that counts, and lighter than the lightest
LEAST_RANGE = 110.0  # grey levels from darkest to lightest: with so many a picture stays as it is
DARKEST, LIGHTEST = 25.0, 155.0  # to which those of a picture with fewer are moved
MOST_NOISE = 4.5  # grey levels, to which the noise may grow with them: what is more looks like something on the floor
LEAST_NOISE = 1.0  # that pictures of whole grey levels have
CHANGE = 0.2  # of the range, by which the levels have to change before they are followed: each time all that is remembered looks different


class Levels:
    """Remembers how the last pictures were spread."""

    def __init__(self, view: FloorView) -> None:
        """Judge by what a view shows of floor and own body."""
        rows, cols = np.nonzero(view.range_m[::EVERY_PX, ::EVERY_PX] < view.reach_m)
        pixels = view.camera_pixels(np.stack([cols, rows], axis=-1) * EVERY_PX).astype(np.intp)
        self._seen = pixels[:, 1], pixels[:, 0]
        self._beside = pixels[:, 1], np.maximum(pixels[:, 0] - 1, 0)
        self._ends: tuple[float, float] | None = None  # darkest and lightest
        self._table: NDArray[np.uint8] | None = None  # the new level of each, (256,), where they change

    def spread(self, picture: Picture) -> Picture:
        """Return a camera picture, BGR, with enough contrast."""
        green = picture[(*self._seen, 1)].astype(np.float64)
        darkest, lightest = quantiles(green, SHARE, 1.0 - SHARE)
        if self._ends is None or _change(self._ends, (darkest, lightest)) > CHANGE:
            noise = robust_sigma(green - picture[(*self._beside, 1)]) / np.sqrt(2.0)
            self._ends, self._table = (darkest, lightest), _table(darkest, lightest, MOST_NOISE / max(noise, LEAST_NOISE))
        return picture if self._table is None else np.asarray(cv2.LUT(picture, self._table), np.uint8)


def _change(one: tuple[float, float], other: tuple[float, float]) -> float:
    """Return by how much darkest and lightest differ, as a share of the range between them."""
    return float(np.abs(np.subtract(one, other)).max()) / max(one[1] - one[0], 1.0)


def _table(darkest: float, lightest: float, most_gain: float) -> NDArray[np.uint8] | None:
    """Return the new level of each, (256,), None where they are to stay as they are."""
    if lightest - darkest >= LEAST_RANGE:
        return None
    gain = min((LIGHTEST - DARKEST) / max(lightest - darkest, 1.0), most_gain)
    if gain <= 1.0:
        return None
    return np.asarray(np.clip(np.rint((np.arange(256) - darkest) * gain + DARKEST), 0, 255), np.uint8)
