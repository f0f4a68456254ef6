"""How much of the arena's floor the map knows, followed by the map's changes."""

from __future__ import annotations

import zlib

import numpy as np
from numpy.typing import NDArray

from mapserver.mapping.floor.grid import TILE_CELLS
from protocol.messages import UNKNOWN, MapTile, MapUpdate


class CoverageMeter:
    """Counts known cells within an area, (x_min, y_min, x_max, y_max) [m; arena]."""

    def __init__(self, area_m: tuple[float, float, float, float]) -> None:
        self._area_m = area_m
        self._known: dict[tuple[int, int], int] = {}
        self._cell_m = 0.0

    def take(self, update: MapUpdate) -> None:
        """Take note of the tiles that have changed."""
        self._cell_m = update.cell_m
        for tile in update.tiles:
            self._known[tile.ix, tile.iy] = int((self._inside(tile) & (_cells(tile) != UNKNOWN)).sum())

    @property
    def share(self) -> float:
        """Return the known share of the area, 0 to 1."""
        x_min, y_min, x_max, y_max = self._area_m
        return sum(self._known.values()) * self._cell_m**2 / ((x_max - x_min) * (y_max - y_min))

    def _inside(self, tile: MapTile) -> NDArray[np.bool_]:
        """Return which cells of a tile have their centres in the area, (TILE_CELLS, TILE_CELLS)."""
        x_min, y_min, x_max, y_max = self._area_m
        x = (tile.ix * TILE_CELLS + np.arange(TILE_CELLS) + 0.5) * self._cell_m
        y = (tile.iy * TILE_CELLS + np.arange(TILE_CELLS) + 0.5) * self._cell_m
        return np.logical_and.outer((y > y_min) & (y < y_max), (x > x_min) & (x < x_max))


def _cells(tile: MapTile) -> NDArray[np.uint8]:
    return np.frombuffer(zlib.decompress(tile.cells), np.uint8).reshape(TILE_CELLS, TILE_CELLS)
