"""The known share of the arena."""

from __future__ import annotations

import zlib

import numpy as np
import pytest

from deploy.coverage_meter import CoverageMeter
from mapserver.mapping.floor.grid import TILE_CELLS
from protocol.messages import FREE, MapTile, MapUpdate

CELL_M = 0.01
TILE_M = CELL_M * TILE_CELLS


def update(ix: int, known_rows: int) -> MapUpdate:
    cells = np.zeros((TILE_CELLS, TILE_CELLS), np.uint8)
    cells[:known_rows] = FREE
    tile = MapTile(ix=ix, iy=0, cells=zlib.compress(cells.tobytes()))
    return MapUpdate(seq=0, stamp_ns=0, cell_m=CELL_M, tiles=(tile,), objects=())


def test_known_cells_within_the_area_are_its_known_share() -> None:
    meter = CoverageMeter((0.0, 0.0, 2.0 * TILE_M, TILE_M))
    meter.take(update(0, TILE_CELLS))
    assert meter.share == pytest.approx(0.5)
    meter.take(update(1, TILE_CELLS // 2))
    assert meter.share == pytest.approx(0.75)


def test_a_tile_that_is_told_again_counts_once_and_one_beyond_the_area_never() -> None:
    meter = CoverageMeter((0.0, 0.0, TILE_M, TILE_M))
    for tile in (update(0, TILE_CELLS), update(0, TILE_CELLS), update(5, TILE_CELLS)):
        meter.take(tile)
    assert meter.share == pytest.approx(1.0)
