"""Polygons in cells: the same whether they end within the mask or reach far beyond it."""

from __future__ import annotations

import numpy as np
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from mapserver.mapping.floor.raster import corners_of, fill

CELLS = st.integers(-600, 1000).map(lambda tenths: tenths / 10.0)
SIDE = 40


def filled(points: list[tuple[float, float]]) -> np.ndarray[tuple[int, int], np.dtype[np.uint8]]:
    mask = np.zeros((SIDE, SIDE), np.uint8)
    fill(mask, corners_of(np.array(points), np.zeros(2), 1.0), 1)
    return mask


def test_a_rectangle_covers_the_cells_it_runs_through() -> None:
    mask = filled([(2.5, 3.5), (6.5, 3.5), (6.5, 5.5), (2.5, 5.5)])
    assert np.argwhere(mask).min(axis=0).tolist() == [3, 2]
    assert np.argwhere(mask).max(axis=0).tolist() == [5, 6]
    assert mask.sum() == 15


@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(CELLS, CELLS), min_size=3, max_size=7))
def test_what_reaches_beyond_the_mask_covers_the_same_cells_within(points: list[tuple[float, float]]) -> None:
    hull = shapely.MultiPoint(points).convex_hull
    mask = filled(list(hull.exterior.coords) if isinstance(hull, shapely.Polygon) else list(hull.coords))
    y, x = np.mgrid[0:SIDE, 0:SIDE] + 0.5
    assert mask[shapely.contains_xy(hull.buffer(-1.0), x, y)].all()
    assert not mask[~shapely.contains_xy(hull.buffer(1.5), x, y)].any()


def test_what_lies_outside_changes_nothing() -> None:
    assert not filled([(-20.0, -20.0), (-3.0, -20.0), (-3.0, 90.0)]).any()
