"""The global occupancy grid: square tiles of cells, allocated where something was seen."""

from __future__ import annotations

import itertools
import zlib
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mapserver.mapping.floor.raster import corners_of, fill
from protocol.geometry import Array
from protocol.messages import OCCUPIED, MapTile

TILE_CELLS = 64
CELL_M = 0.01

FREE_BELOW, BARE_BELOW, SURELY_BARE_BELOW = -0.2, -0.6, -1.2  # log-odds after one, three and five sharp looks at the floor
BASE_ABOVE = 0.8  # after two sharp looks at a base
LEAST_LOG_ODDS = -1.5
MOST_LOG_ODDS = 1.5

Mask = NDArray[np.bool_]
LogOdds = NDArray[np.float32]
Cells = NDArray[np.uint8]
TileIndex = tuple[int, int]  # column and row of tiles: tile (0, 0) has its lowest corner in the arena's origin
Place = tuple[slice, slice]


@dataclass
class Tile:
    """One tile's layers, each of shape (TILE_CELLS, TILE_CELLS), row 0 at the lowest y.

    `log_odds` are those of something standing there instead of bare floor; `cells` are UNKNOWN, FREE or OCCUPIED, as last classified.
    """

    log_odds: LogOdds = field(default_factory=lambda: np.zeros((TILE_CELLS, TILE_CELLS), np.float32))
    cells: Cells = field(default_factory=lambda: np.zeros((TILE_CELLS, TILE_CELLS), np.uint8))


class Window(NamedTuple):
    """A rectangle of whole tiles: first tile (ix, iy) and number of tiles along x and y."""

    ix: int
    iy: int
    columns: int
    rows: int

    def tiles(self) -> Iterator[tuple[TileIndex, Place]]:
        """Yield every tile's index and where it lies in an array of `shape`."""
        return self._at(itertools.product(range(self.rows), range(self.columns)))

    def tiles_with_any(self, cells: Mask | Cells) -> Iterator[tuple[TileIndex, Place]]:
        """Yield, as `tiles` does, those in which any of `cells`, shape `shape`, is not zero."""
        tiled = (cells != 0).reshape(self.rows, TILE_CELLS, self.columns, TILE_CELLS)
        return self._at(np.argwhere(tiled.any(axis=3).any(axis=1)).tolist())

    def _at(self, positions: Iterable[Sequence[int]]) -> Iterator[tuple[TileIndex, Place]]:
        for row, column in positions:
            yield (self.ix + column, self.iy + row), (_tile_span(row), _tile_span(column))

    def squared_distances_m2(self, point_m: Array, every: int = 1) -> NDArray[np.float32]:
        """Return the squared distance from a point, shape (2,) [m; arena], to the centre of every block of `every` x `every` cells."""
        rows, columns = (count // every for count in self.shape)
        x_m = (np.arange(columns) + 0.5) * (every * CELL_M) + (self.origin_m[0] - point_m[0])
        y_m = (np.arange(rows) + 0.5) * (every * CELL_M) + (self.origin_m[1] - point_m[1])
        return np.asarray(x_m[None, :] ** 2 + y_m[:, None] ** 2, dtype=np.float32)

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of cells."""
        return self.rows * TILE_CELLS, self.columns * TILE_CELLS

    @property
    def origin_m(self) -> Array:
        """The lowest corner, shape (2,) [m; arena]."""
        return np.array([self.ix, self.iy]) * (TILE_CELLS * CELL_M)


class Grid:
    """All tiles, and which of them were touched since they were last classified."""

    def __init__(self) -> None:
        """Start with no tile."""
        self._tiles: dict[TileIndex, Tile] = {}
        self._touched: set[TileIndex] = set()
        self._covered: set[TileIndex] = set()  # by things, when last classified

    def log_odds(self, window: Window) -> LogOdds:
        """Return a copy of the log-odds in a window, shape `window.shape`; 0 where no tile is."""
        gathered = np.zeros(window.shape, dtype=np.float32)
        for index, place in window.tiles():
            if (tile := self._tiles.get(index)) is not None:
                gathered[place] = tile.log_odds
        return gathered

    def log_odds_at(self, x_m: Array, y_m: Array) -> LogOdds:
        """Return the log-odds, (rows, columns), in the cells at x (columns,) and y (rows,), both growing [m; arena]; 0 where no tile is."""
        window = _window_of(np.array([x_m[0], y_m[0]]), np.array([x_m[-1], y_m[-1]]))
        columns, rows = (np.floor((at_m - low_m) / CELL_M).astype(int) for at_m, low_m in zip((x_m, y_m), window.origin_m, strict=True))
        return self.log_odds(window)[np.ix_(rows, columns)]

    def store(self, window: Window, log_odds: LogOdds, seen: Mask | Cells) -> None:
        """Replace the log-odds in a window by clipped ones; tiles without any cell `seen`, shape `window.shape`, stay as they are."""
        clipped = np.clip(log_odds, LEAST_LOG_ODDS, MOST_LOG_ODDS)
        for index, place in window.tiles_with_any(seen):
            self._tile(index).log_odds[:] = clipped[place]
            self._touched.add(index)

    def _tile(self, index: TileIndex) -> Tile:
        tile = self._tiles.get(index)
        if tile is None:
            tile = self._tiles[index] = Tile()
        return tile

    def classify(self, footprints: Sequence[Array]) -> list[TileIndex]:
        """Classify the cells of all tiles touched, or covered by things now or before, and return the tiles in which any changed, sorted.

        OCCUPIED are cells in which the base of something was seen, and those inside one of the `footprints`, (n, 2) [m; arena] each, that
        were not seen bare; elsewhere cells are FREE where bare floor was seen.
        """
        standing = self._standing(footprints)
        indices = sorted(self._touched | self._covered | standing.keys())
        self._touched, self._covered = set(), set(standing)
        return [index for index in indices if self._classify(index, standing.get(index))]

    def _standing(self, footprints: Sequence[Array]) -> dict[TileIndex, Mask]:
        """Return the cells inside footprints, for every tile that has any."""
        standing: dict[TileIndex, Mask] = {}
        for footprint in footprints:
            window = _window_of(footprint.min(axis=0) - CELL_M, footprint.max(axis=0) + CELL_M)
            inside = np.zeros(window.shape, np.uint8)
            fill(inside, corners_of(footprint, window.origin_m, CELL_M), 1)
            for index, place in window.tiles_with_any(inside):
                standing[index] = standing.get(index, False) | (inside[place] > 0)
        return standing

    def _classify(self, index: TileIndex, standing: Mask | None) -> bool:
        tile = self._tile(index)
        cells = (tile.log_odds < FREE_BELOW).view(np.uint8)  # FREE, else UNKNOWN
        cells[tile.log_odds > BASE_ABOVE] = OCCUPIED
        if standing is not None:
            cells[standing & (tile.log_odds >= BARE_BELOW)] = OCCUPIED
        changed = not np.array_equal(cells, tile.cells)
        tile.cells = cells
        return changed

    def indices(self) -> list[TileIndex]:
        """Return all tiles' indices, sorted."""
        return sorted(self._tiles)

    def cells(self) -> tuple[Cells, Array]:
        """Return all tiles as one array, shape (rows, columns), UNKNOWN where no tile is, and its lowest corner, shape (2,) [m; arena]."""
        indices = np.array(self.indices() or [(0, 0)])
        first, last = indices.min(axis=0), indices.max(axis=0)
        columns, rows = last - first + 1
        window = Window(int(first[0]), int(first[1]), int(columns), int(rows))
        gathered = np.zeros(window.shape, np.uint8)
        for index, place in window.tiles():
            if (tile := self._tiles.get(index)) is not None:
                gathered[place] = tile.cells
        return gathered, window.origin_m

    def message(self, index: TileIndex) -> MapTile:
        """Return one tile as it goes on the wire."""
        ix, iy = index
        return MapTile(ix=ix, iy=iy, cells=zlib.compress(self._tiles[index].cells.tobytes(), level=1))


def window_around(centre_m: Array, radius_m: float) -> Window:
    """Return the whole tiles that cover a circle around `centre_m`, shape (2,) [m; arena]."""
    return _window_of(centre_m - radius_m, centre_m + radius_m)


def _window_of(lowest_m: Array, highest_m: Array) -> Window:
    """Return the whole tiles that cover a rectangle between two corners, shape (2,) [m; arena]."""
    tile_m = TILE_CELLS * CELL_M
    first = np.floor(lowest_m / tile_m).astype(int)
    last = np.floor(highest_m / tile_m).astype(int)
    columns, rows = last - first + 1
    return Window(int(first[0]), int(first[1]), int(columns), int(rows))


def _tile_span(number: int) -> slice:
    return slice(number * TILE_CELLS, (number + 1) * TILE_CELLS)
