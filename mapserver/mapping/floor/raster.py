"""Polygons drawn into squares of cells."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from protocol.geometry import Array

SHIFT_BITS = 4  # cv2 draws at 1/16 of a cell

Mask = NDArray[np.uint8]
Corners = NDArray[np.int32]  # (..., 2) column and row, in 1/16 of a cell; a whole number is a cell's centre


def corners_of(points_m: Array, origin_m: Array, cell_m: float) -> Corners:
    """Return points, shape (..., 2), in cells of a mask whose first cell has its lowest corner in `origin_m`, shape (2,)."""
    return np.asarray(np.rint(((points_m - origin_m) / cell_m - 0.5) * (1 << SHIFT_BITS)), dtype=np.int32)


def fill(mask: Mask, polygon: Corners, value: int) -> None:
    """Set the cells that a polygon, shape (n, 2), covers or runs through; it may reach beyond the mask.

    What does is drawn on a canvas of its own, for cv2.fillPoly distorts polygons that cross the border of a picture.
    """
    x, y, width, height = cv2.boundingRect(polygon)
    left, right = x >> SHIFT_BITS, (x + width - 1 >> SHIFT_BITS) + 2
    bottom, top = y >> SHIFT_BITS, (y + height - 1 >> SHIFT_BITS) + 2
    rows, columns = mask.shape
    if left >= 0 and bottom >= 0 and right <= columns and top <= rows:
        cv2.fillPoly(mask, [polygon], value, lineType=cv2.LINE_8, shift=SHIFT_BITS)
        return
    inside = slice(max(bottom, 0), min(top, rows)), slice(max(left, 0), min(right, columns))
    if inside[0].start < inside[0].stop and inside[1].start < inside[1].stop:
        canvas = np.zeros((top - bottom, right - left), np.uint8)
        moved = polygon - np.array([left << SHIFT_BITS, bottom << SHIFT_BITS], dtype=np.int32)
        cv2.fillPoly(canvas, [moved], 1, lineType=cv2.LINE_8, shift=SHIFT_BITS)
        covered = canvas[inside[0].start - bottom : inside[0].stop - bottom, inside[1].start - left : inside[1].stop - left]
        mask[inside][covered > 0] = value
