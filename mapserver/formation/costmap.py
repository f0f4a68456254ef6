"""How far from anything solid each place is: what paths are planned on."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, TypeVar

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from mapserver.formation.floor import Bounds, Floor, corners_m, cut_out
from protocol.geometry import Array
from protocol.messages import OCCUPIED, UNKNOWN

OPEN_MARGIN_M = 1.0  # of unknown floor around all that is known, where nobody gave bounds
MOVING_MARGIN_M = 0.15  # more than from what stands: it may come nearer
SPECK_CELLS = 3  # that hang together are no thing's base, but what is left of a shadow; the robots themselves still keep clear of it


T = TypeVar("T", bound=np.generic)


class Disc(NamedTuple):
    """Something round that stands in the way."""

    centre_m: Array  # (2,) [arena]
    radius_m: float


class CostMap(NamedTuple):
    """The floor within the bounds, and the distance from every cell's centre to the nearest thing or bound, shape (rows, columns) [m]."""

    floor: Floor
    clearances_m: NDArray[np.float32]

    def clearance_m(self, points_m: Array) -> NDArray[np.float32]:
        """Return the distance to the nearest thing at points, shape (..., 2) [m; arena]; 0 beyond the bounds."""
        return np.asarray(self._looked_up(self.clearances_m, points_m, np.float32(0.0)))

    def is_unknown(self, points_m: Array) -> NDArray[np.bool_]:
        """Tell at points, shape (..., 2) [m; arena], whether nobody has seen the floor there."""
        return np.asarray(self._looked_up(self.floor.cells, points_m, np.uint8(UNKNOWN)) == UNKNOWN)

    def is_occupied(self, points_m: Array) -> NDArray[np.bool_]:
        """Tell at points, shape (..., 2) [m; arena], whether something stands there."""
        return np.asarray(self._looked_up(self.floor.cells, points_m, np.uint8(UNKNOWN)) == OCCUPIED)

    def _looked_up(self, layer: NDArray[T], points_m: Array, beyond: T) -> NDArray[T]:
        cells = np.floor((points_m - self.floor.origin_m) / self.floor.cell_m).astype(int)
        columns, rows = cells[..., 0], cells[..., 1]
        height, width = layer.shape
        inside = (columns >= 0) & (columns < width) & (rows >= 0) & (rows < height)
        return np.where(inside, layer[np.clip(rows, 0, height - 1), np.clip(columns, 0, width - 1)], beyond)

    def too_near(self, way_m: Array, least_m: ArrayLike) -> NDArray[np.bool_]:
        """Tell where along a way, shape (n, 2) [m; arena], something is nearer than `least_m`; who is as near at its start may leave."""
        clearances_m = self.clearance_m(way_m)
        return np.asarray(clearances_m < np.minimum(least_m, float(clearances_m[0]) - self.floor.cell_m))

    def uphill(self, points_m: Array, reach_m: float) -> Array:
        """Return the gradient of the clearance, shape (n, 2), by differences over +-`reach_m`: it points away from what is near."""
        steps_m = reach_m * np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]])
        east, west, north, south = self.clearance_m(points_m[None] + steps_m[:, None])
        return np.stack([east - west, north - south], axis=1).astype(np.float64) / (2.0 * reach_m)

    def with_discs(self, discs: Sequence[Disc]) -> CostMap:
        """Return the map with more things standing on it."""
        clearances_m = self.clearances_m
        rows, columns = clearances_m.shape
        for disc in discs:
            x_m = (np.arange(columns) + 0.5) * self.floor.cell_m + (self.floor.origin_m[0] - disc.centre_m[0])
            y_m = (np.arange(rows) + 0.5) * self.floor.cell_m + (self.floor.origin_m[1] - disc.centre_m[1])
            away_m = np.sqrt(x_m[None] ** 2 + y_m[:, None] ** 2) - disc.radius_m
            clearances_m = np.minimum(clearances_m, np.maximum(away_m, 0.0).astype(np.float32))
        return CostMap(self.floor, clearances_m)


def cost_map(floor: Floor, bounds: Bounds | None, places_m: Array, moving: Sequence[Array]) -> CostMap:
    """Return the map within the bounds, else around what is known and `places_m`, (n, 2) [m; arena].

    `moving` footprints, (n, 2) each, get a wide berth.
    """
    frame = bounds or Bounds.around(np.vstack([corners_m(floor), places_m]) if floor.cells.any() else places_m, OPEN_MARGIN_M)
    within = cut_out(floor, frame)
    solid = cv2.copyMakeBorder(_things(within.cells).view(np.uint8), 1, 1, 1, 1, cv2.BORDER_CONSTANT, value=1)
    cells = cv2.distanceTransform(1 - solid, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)[1:-1, 1:-1]
    clearances_m = np.maximum(cells - 0.5, 0.0).astype(np.float32) * np.float32(floor.cell_m)
    return CostMap(within, clearances_m).with_discs([_berth(footprint_m) for footprint_m in moving])


def _things(cells: NDArray[np.uint8]) -> NDArray[np.bool_]:
    """Return which cells, shape (rows, columns), something stands on: all that are occupied but specks."""
    _, labels, about, _ = cv2.connectedComponentsWithStats((cells == OCCUPIED).view(np.uint8), connectivity=8)
    is_thing = about[:, cv2.CC_STAT_AREA] > SPECK_CELLS
    is_thing[0] = False  # the floor
    return np.asarray(is_thing[labels])


def unknown_of(cost_map: CostMap) -> NDArray[np.bool_]:
    """Return which cells nobody has seen yet, shape (rows, columns)."""
    return np.asarray(cost_map.floor.cells == UNKNOWN)


def _berth(footprint_m: Array) -> Disc:
    centre_m = footprint_m.mean(axis=0)
    return Disc(centre_m, float(np.hypot(*(footprint_m - centre_m).T).max()) + MOVING_MARGIN_M)
