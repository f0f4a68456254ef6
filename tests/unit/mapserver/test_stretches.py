"""Outlines that are not convex: a wall round a corner is cut at the corner, and what is nearly convex stays whole."""

import numpy as np
import pytest
import shapely

from mapserver.mapping.views.stretches import stretches_of

EYE = np.array([0.0, 0.0])
CORNER = shapely.Polygon([(-1.0, 1.0), (1.0, 1.0), (1.0, -1.0), (1.4, -1.0), (1.4, 1.4), (-1.0, 1.4)])  # of two walls, seen from inside


def test_a_wall_is_cut_at_its_corner() -> None:
    parts = list(stretches_of(CORNER, EYE))
    assert len(parts) == 2
    assert sum(part.area for part in parts) == pytest.approx(CORNER.area)
    assert all(part.area > 0.85 * part.convex_hull.area for part in parts)
    assert shapely.distance(shapely.intersection(*parts), shapely.Point(1.0, 1.0)) < 1e-6


def test_what_is_convex_stays_whole() -> None:
    box = shapely.box(0.5, 0.5, 1.0, 0.8)
    assert list(stretches_of(box, EYE)) == [box]


def test_four_walls_become_pieces_of_the_same_area() -> None:
    room = shapely.box(-1.5, -1.5, 1.5, 1.5).difference(shapely.box(-1.0, -1.0, 1.0, 1.0)).difference(shapely.box(-1.6, -0.01, 0.0, 0.01))
    parts = list(stretches_of(room, EYE))
    assert len(parts) > 3
    assert sum(part.area for part in parts) == pytest.approx(room.area)


def test_an_eye_on_the_corner_itself_cuts_nothing_and_does_no_harm() -> None:
    assert sum(part.area for part in stretches_of(CORNER, np.array([1.0, 1.0]))) == pytest.approx(CORNER.area)
