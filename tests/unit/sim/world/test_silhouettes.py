"""Outlines of upright prisms, and how exactly they cover pixels."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocol.geometry import Array
from sim.world.silhouettes import blend, both_ways, coverage, facing, outline

SQUARE = np.array([(1.0, -0.5), (2.0, -0.5), (2.0, 0.5), (1.0, 0.5)])
EYE = np.array([0.0, 0.0, 0.5])
CANVAS = (60, 80)


def polygon(centre: tuple[float, float], radius: float, sides: int, turn_rad: float = 0.0) -> Array:
    angles = turn_rad + np.arange(sides) * (2.0 * math.pi / sides)
    return np.array(centre) + radius * np.column_stack([np.cos(angles), np.sin(angles)])


def area_of(ring: Array) -> float:
    """Return the area within a ring, (n, 2), by the shoelace formula."""
    x, y = ring.T
    return 0.5 * abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1)))


def picture_of(ring: Array) -> Array:
    """Return how far a ring covers each pixel of the canvas."""
    whole = np.zeros(CANVAS)
    where = coverage(ring, CANVAS)
    if where is not None:
        whole[where.rows, where.cols] = where.alpha
    return whole


@given(
    u=st.floats(20.0, 60.0),
    v=st.floats(20.0, 40.0),
    radius=st.floats(0.3, 18.0),
    sides=st.integers(3, 40),
    turn_rad=st.floats(0.0, 6.3),
)
def test_a_polygon_covers_its_area(u: float, v: float, radius: float, sides: int, turn_rad: float) -> None:
    ring = polygon((u, v), radius, sides, turn_rad)
    assert picture_of(ring).sum() == pytest.approx(area_of(ring), rel=1e-4, abs=1e-4)


def test_what_is_covered_is_not_shifted() -> None:
    alpha = picture_of(polygon((30.3, 20.8), 12.3, 40))
    rows, columns = np.indices(CANVAS)
    assert float((alpha * columns).sum() / alpha.sum()) == pytest.approx(30.3, abs=0.005)
    assert float((alpha * rows).sum() / alpha.sum()) == pytest.approx(20.8, abs=0.005)


def test_pixels_are_covered_by_their_share() -> None:
    ring = np.array([(9.75, 4.5), (12.5, 4.5), (12.5, 6.0), (9.75, 6.0)])  # pixel 10 reaches from 9.5 to 10.5
    alpha = picture_of(ring)
    assert alpha[5, 9:14].tolist() == pytest.approx([0.0, 0.75, 1.0, 1.0, 0.0])
    assert alpha[6, 9:14].tolist() == pytest.approx([0.0, 0.375, 0.5, 0.5, 0.0])
    assert alpha[4].sum() == alpha[7].sum() == 0.0


@pytest.mark.parametrize("way_round", [1, -1])
def test_a_polygon_may_lie_partly_or_wholly_beyond_the_canvas(way_round: int) -> None:
    half = picture_of(polygon((-0.5, 29.5), 10.0, 4)[::way_round])
    assert half.sum() == pytest.approx(100.0, rel=1e-5)
    assert half[:, 40:].sum() == 0.0
    assert picture_of(polygon((79.5, 59.5), 10.0, 4)[::way_round]).sum() == pytest.approx(50.0, rel=1e-5)
    assert coverage(polygon((-30.0, 20.0), 10.0, 8), CANVAS) is None


def test_blending_mixes_by_the_share_that_is_covered() -> None:
    canvas = np.full((*CANVAS, 3), 100, np.uint8)
    where = coverage(np.array([(9.75, 4.5), (12.5, 4.5), (12.5, 6.5), (9.75, 6.5)]), CANVAS)
    assert where is not None
    blend(canvas, where, np.full((*where.alpha.shape, 3), 200, np.uint8))
    assert canvas[5, 9:14, 0].tolist() == [100, 175, 200, 200, 100]


def test_sides_face_an_eye_in_front_of_them() -> None:
    assert facing(SQUARE, EYE[:2]).tolist() == [False, False, False, True]
    assert facing(SQUARE, np.array([0.0, -2.0])).tolist() == [True, False, False, True]


def test_of_a_low_prism_the_base_in_front_and_the_top_behind_are_seen() -> None:
    loop = outline(SQUARE, 0.3, EYE)
    assert loop is not None
    far, near = loop[loop[:, 0] > 1.0], loop[loop[:, 0] == 1.0]
    assert set(far[:, 2].tolist()) == {0.3}
    assert (near[:, 2].min(), near[:, 2].max()) == (0.0, 0.3)
    assert (np.abs(near[(near[:, 2] > 0.0), 1]) == 0.5).all()


def test_of_a_prism_taller_than_the_eye_only_its_front_is_seen() -> None:
    loop = outline(SQUARE, 0.9, EYE)
    assert loop is not None
    assert set(loop[:, 0].tolist()) == {1.0}
    inner = loop[np.abs(loop[:, 1]) < 0.5, 2]
    assert set(inner.tolist()) == {0.0, 0.9}


def test_from_above_a_prism_is_its_top_and_from_within_it_is_nothing() -> None:
    above = np.array([1.5, 0.0, 0.5])
    loop = outline(SQUARE, 0.3, above)
    assert loop is not None
    assert set(loop[:, 2].tolist()) == {0.3}
    assert outline(SQUARE, 0.9, above) is None


def test_both_ways_round_a_footprint_meet_at_their_ends() -> None:
    near, behind = both_ways(SQUARE, EYE)
    assert near[0].tolist() == behind[-1].tolist() == [1.0, 0.5]
    assert near[-1].tolist() == behind[0].tolist() == [1.0, -0.5]
