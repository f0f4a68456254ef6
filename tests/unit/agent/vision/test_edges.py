"""Where a thing ends, to a fraction of a pixel, whatever the mask of it took in beside it."""

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from agent.vision.edges import LEAST_CONTRAST, MOST_INWARD_PX, USUAL_INWARD_PX, located
from agent.vision.outlines import find_borders
from protocol.geometry import Array
from tests.unit.agent.floor_worlds import VIEW

ROWS, COLS = VIEW.valid.shape
CENTRE_PX = VIEW.nadir_px - np.array([0.0, 200.3])
FLOOR, THING = (150.0, 150.0, 150.0), (60.0, 90.0, 190.0)
FINER = 8


def disc_mask(radius_px: float) -> NDArray[np.uint8]:
    v, u = np.mgrid[:ROWS, :COLS]
    return np.asarray(np.hypot(u - CENTRE_PX[0], v - CENTRE_PX[1]) < radius_px).astype(np.uint8)


def picture_of_disc(radius_px: float, thing: tuple[float, ...] = THING, noise: float = 0.0) -> NDArray[np.uint8]:
    """Return the picture of a disc on the floor, as blurred as a lens and its pixels make it."""
    v, u = np.mgrid[:ROWS, :COLS]
    share = np.clip(radius_px + 0.5 - np.hypot(u - CENTRE_PX[0], v - CENTRE_PX[1]), 0.0, 1.0)
    sharp = np.array(FLOOR) + share[..., None] * (np.array(thing) - FLOOR)
    grain = np.random.default_rng(1).normal(0.0, noise, sharp.shape)
    return np.asarray(np.clip(np.rint(cv2.GaussianBlur(sharp, (0, 0), 0.8) + grain), 0.0, 255.0), np.uint8)


def radii_px(mask: NDArray[np.uint8], picture: NDArray[np.uint8]) -> Array:
    (edge,) = located(find_borders(mask, VIEW.nadir_px, 25.0), mask, VIEW, picture).edges
    return np.asarray(np.hypot(*(edge - CENTRE_PX).T))


@pytest.mark.parametrize("too_far_px", [1.0, 2.0, 4.0])
@pytest.mark.parametrize("noise", [0.0, 4.0])
def test_the_edge_is_where_the_picture_changes_however_far_the_mask_reaches(too_far_px: float, noise: float) -> None:
    found_px = radii_px(disc_mask(30.3 + too_far_px), picture_of_disc(30.3, noise=noise))
    assert np.median(found_px) == pytest.approx(30.3, abs=0.4)
    assert np.quantile(np.abs(found_px - 30.3), 0.9) < 0.8


def test_what_hardly_differs_from_the_floor_ends_as_far_inside_its_mask_as_things_usually_do() -> None:
    alike = tuple(level + LEAST_CONTRAST / 9.0 for level in FLOOR)
    found_px = radii_px(disc_mask(30.0), picture_of_disc(27.0, alike))
    assert np.median(found_px) == pytest.approx(30.0 - USUAL_INWARD_PX, abs=0.7)


def test_an_edge_is_not_looked_for_deep_inside_the_mask() -> None:
    found_px = radii_px(disc_mask(30.0), picture_of_disc(15.0))
    assert found_px.min() > 29.0 - MOST_INWARD_PX


def test_what_is_thin_keeps_half_of_its_width_at_least() -> None:
    bar = np.zeros((ROWS, COLS), np.uint8)
    u, v = np.rint(CENTRE_PX).astype(int)
    bar[v - 2 : v + 3, u - 40 : u + 41] = 1
    picture = np.full((ROWS, COLS, 3), 150, np.uint8)
    picture[v, u - 40 : u + 41] = 30
    (edge,) = located(find_borders(bar, VIEW.nadir_px, 25.0), bar, VIEW, picture).edges
    middle = edge[np.abs(edge[:, 0] - u) < 30]
    assert (np.abs(middle[:, 1] - v) <= 2.0).all()
    assert np.median(np.abs(middle[:, 1] - v)) < 1.5
    assert middle[middle[:, 1] < v + 0.01].size
    assert middle[middle[:, 1] > v - 0.01].size


def test_a_small_region_that_is_not_compact_stays_as_the_mask_has_it() -> None:
    angle = np.zeros((ROWS, COLS), np.uint8)
    u, v = np.rint(CENTRE_PX).astype(int)
    angle[v : v + 30, u : u + 6] = angle[v + 24 : v + 30, u : u + 30] = 1
    borders = find_borders(angle, VIEW.nadir_px, 25.0)
    assert borders.compact == [False]
    picture = np.full((ROWS, COLS, 3), 150, np.uint8)
    picture[angle > 0] = 30
    np.testing.assert_array_equal(located(borders, angle, VIEW, picture).edges[0], borders.pixels[0])


def test_where_the_view_ends_a_border_stays_where_it_is() -> None:
    rim = VIEW.valid & (VIEW.range_m > 0.8 * VIEW.reach_m) & (np.abs(VIEW.bearing_rad) < 0.3)
    mask = rim.astype(np.uint8)
    borders = find_borders(mask, VIEW.nadir_px, 25.0)
    (border,), (edge,) = borders.pixels, located(borders, mask, VIEW, np.full((ROWS, COLS, 3), 150, np.uint8)).edges
    kept = border[:: len(border) // len(edge)][: len(edge)]
    outermost = VIEW.range_m[kept[:, 1], kept[:, 0]] > 0.99 * VIEW.reach_m
    assert outermost.any()
    np.testing.assert_array_equal(edge[outermost], kept[outermost])


def test_without_things_there_are_no_edges() -> None:
    nothing = np.zeros((ROWS, COLS), np.uint8)
    assert located(find_borders(nothing, VIEW.nadir_px, 25.0), nothing, VIEW, np.zeros((ROWS, COLS, 3), np.uint8)).edges == []
