"""Correction of a whole picture for the lens, which correcting only its feature points saves."""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from agent.vision.lens import Lens
from protocol.geometry import Array

HALF_VIEW_RAD = math.radians(70.0)  # from the middle of the corrected picture to its left and right border


class WholePictureCorrection:
    """Makes pictures of an ordinary, rectilinear lens out of fisheye pictures, by a map that is made once."""

    def __init__(self, lens: Lens, size_px: tuple[int, int]) -> None:
        width, height = size_px
        focal_px = 0.5 * width / math.tan(HALF_VIEW_RAD)
        u, v = np.meshgrid(np.arange(width) - 0.5 * (width - 1), np.arange(height) - 0.5 * (height - 1))
        rays = np.stack([u, v, np.full_like(u, focal_px)], axis=-1).reshape(-1, 3)
        self._map = remap_table(lens.project(rays).reshape(height, width, 2))

    def correct(self, picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Return a picture (rows, cols, 3) as an ordinary lens would have taken it."""
        return np.asarray(cv2.remap(picture, self._map[0], self._map[1], cv2.INTER_LINEAR), np.uint8)


def remap_table(pixels: Array) -> tuple[NDArray[np.integer], NDArray[np.integer]]:
    """Return what cv2.remap needs to fetch every pixel of a picture from a place, (rows, cols, 2) u, v, in fixed point: its fastest way."""
    u, v = np.ascontiguousarray(np.moveaxis(pixels, -1, 0), dtype=np.float32)
    whole, fraction = cv2.convertMaps(u, v, cv2.CV_16SC2)
    return np.asarray(whole, np.int16), np.asarray(fraction, np.uint16)
