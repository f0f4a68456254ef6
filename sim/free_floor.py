"""Where a round body can go: a grid flood fill over the floor that obstacles and walls leave free."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy import ndimage

from protocol.geometry import Array

CELL_M = 0.02


class FreeFloor:
    """An arena's floor as a grid of clearances: how far each cell's centre is from the nearest obstacle or wall."""

    def __init__(self, bounds_m: tuple[float, float, float, float], obstacles: Sequence[shapely.Polygon]) -> None:
        """Measure the floor within bounds (x min, y min, x max, y max)."""
        self._x_min_m, self._y_min_m, x_max_m, y_max_m = bounds_m
        x_m = np.arange(self._x_min_m + CELL_M / 2, x_max_m, CELL_M)
        y_m = np.arange(self._y_min_m + CELL_M / 2, y_max_m, CELL_M)
        solid = shapely.union_all([shapely.box(*bounds_m).exterior, *obstacles])
        shapely.prepare(solid)
        self._clearance_m: Array = shapely.distance(solid, shapely.points(*np.meshgrid(x_m, y_m)))

    def reachable(self, start_m: tuple[float, float], radius_m: float) -> NDArray[np.bool_]:
        """Return the cells, (rows of y, columns of x), to which a disc can move from `start_m`; none where it cannot stand there."""
        regions, _ = ndimage.label(self._clearance_m >= radius_m)
        region = regions[self._cell(start_m)]
        return np.asarray((regions == region) & (region > 0))

    def is_reachable(self, start_m: tuple[float, float], goal_m: tuple[float, float], radius_m: float) -> bool:
        """Tell whether a disc can move from start to goal."""
        return bool(self.reachable(start_m, radius_m)[self._cell(goal_m)])

    def columns(self, cells: NDArray[np.bool_]) -> Array:
        """Return the x [m] of every column in which there is one of these cells."""
        return np.asarray(self._x_min_m + CELL_M * (np.flatnonzero(cells.any(axis=0)) + 0.5), dtype=np.float64)

    def _cell(self, point_m: tuple[float, float]) -> tuple[int, int]:
        rows, columns = self._clearance_m.shape
        row = int((point_m[1] - self._y_min_m) / CELL_M)
        column = int((point_m[0] - self._x_min_m) / CELL_M)
        return min(max(row, 0), rows - 1), min(max(column, 0), columns - 1)
