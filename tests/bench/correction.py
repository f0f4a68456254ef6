"""Correction of a whole picture for the lens, which correcting only its feature points saves."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from agent.vision.lens import Lens
from agent.vision.remap_table import RemapTable

HALF_VIEW_RAD = math.radians(70.0)  # from the middle of the corrected picture to its left and right border


class WholePictureCorrection:
    """Makes pictures of an ordinary, rectilinear lens out of fisheye pictures, by a map that is made once."""

    def __init__(self, lens: Lens, size_px: tuple[int, int]) -> None:
        width, height = size_px
        focal_px = 0.5 * width / math.tan(HALF_VIEW_RAD)
        u, v = np.meshgrid(np.arange(width) - 0.5 * (width - 1), np.arange(height) - 0.5 * (height - 1))
        rays = np.stack([u, v, np.full_like(u, focal_px)], axis=-1).reshape(-1, 3)
        self._table = RemapTable(lens.project(rays).reshape(height, width, 2))

    def correct(self, picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Return a picture (rows, cols, 3) as an ordinary lens would have taken it."""
        return self._table.sample(picture)
