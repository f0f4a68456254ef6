"""The mapped floor as the formation reads it: one array of cells."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from protocol.geometry import Array


class Floor(NamedTuple):
    """Cells, shape (rows, columns), UNKNOWN, FREE or OCCUPIED, row 0 at the lowest y, and their lowest corner, shape (2,) [m; arena]."""

    cells: NDArray[np.uint8]
    origin_m: Array
    cell_m: float


class Bounds(NamedTuple):
    """A rectangle in the arena [m]."""

    x_min_m: float
    y_min_m: float
    x_max_m: float
    y_max_m: float

    @classmethod
    def around(cls, points_m: Array, margin_m: float) -> Bounds:
        """Return the least rectangle that keeps `margin_m` around points, shape (n, 2)."""
        (x_min, y_min), (x_max, y_max) = points_m.min(axis=0) - margin_m, points_m.max(axis=0) + margin_m
        return cls(float(x_min), float(y_min), float(x_max), float(y_max))


def cut_out(floor: Floor, bounds: Bounds) -> Floor:
    """Return the floor within the bounds, UNKNOWN where it has no cells."""
    first = np.floor((np.array(bounds[:2]) - floor.origin_m) / floor.cell_m + 0.5).astype(int)
    columns, rows = np.maximum(np.rint((np.array(bounds[2:]) - bounds[:2]) / floor.cell_m).astype(int), 1)
    cells = np.zeros((rows, columns), np.uint8)
    low, high = np.maximum(first, 0), np.minimum(first + np.array([columns, rows]), floor.cells.shape[::-1])
    if (low < high).all():
        place = tuple(slice(low[axis] - first[axis], high[axis] - first[axis]) for axis in (1, 0))
        cells[place] = floor.cells[low[1] : high[1], low[0] : high[0]]
    return Floor(cells, floor.origin_m + first * floor.cell_m, floor.cell_m)


def corners_m(floor: Floor) -> Array:
    """Return the lowest and the highest corner, shape (2, 2) [m; arena]."""
    return np.array([floor.origin_m, floor.origin_m + np.array(floor.cells.shape[::-1]) * floor.cell_m])
