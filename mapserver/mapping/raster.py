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
    first, last = polygon.min(axis=0) >> SHIFT_BITS, (polygon.max(axis=0) >> SHIFT_BITS) + 2
    if (first >= 0).all() and (last <= mask.shape[::-1]).all():
        cv2.fillPoly(mask, [polygon], value, lineType=cv2.LINE_8, shift=SHIFT_BITS)
        return
    low, high = np.maximum(first, 0), np.minimum(last, mask.shape[::-1])
    if (low < high).all():
        columns, rows = last - first
        canvas = np.zeros((int(rows), int(columns)), np.uint8)
        cv2.fillPoly(canvas, [polygon - (first << SHIFT_BITS)], 1, lineType=cv2.LINE_8, shift=SHIFT_BITS)
        covered = canvas[low[1] - first[1] : high[1] - first[1], low[0] - first[0] : high[0] - first[0]]
        mask[low[1] : high[1], low[0] : high[0]][covered > 0] = value
