"""Tables of pixels to be sampled, in the form that `cv2.remap` reads fastest, for places in the picture that stay the same."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from agent.vision.floor_view import Picture

OUTSIDE_PX = -1e3  # where the lens sees nothing: black


class RemapTable:
    """Pixels to be sampled in every picture of one size."""

    def __init__(self, pixels: NDArray[np.floating]) -> None:
        """Take pixels, (rows, cols, 2) u, v, NaN where nothing is seen."""
        across, down = (np.ascontiguousarray(np.nan_to_num(pixels[..., axis], nan=OUTSIDE_PX), np.float32) for axis in (0, 1))
        self._whole, self._fraction = cv2.convertMaps(across, down, cv2.CV_16SC2)

    def sample(self, picture: Picture) -> Picture:
        """Return what a picture of one or three channels shows at the pixels, interpolated, (rows, cols) or (rows, cols, 3)."""
        return np.asarray(cv2.remap(picture, self._whole, self._fraction, cv2.INTER_LINEAR), np.uint8)

    def pick(self, picture: Picture) -> Picture:
        """Return the values of the pixels' whole parts, those up to one to the left and above: at half the cost of interpolation."""
        return np.asarray(cv2.remap(picture, self._whole, self._fraction, cv2.INTER_NEAREST), np.uint8)
