"""Regions of a mask, and their outlines on the floor."""

import numpy as np
import pytest
from numpy.typing import NDArray

from agent.vision.outlines import MARGIN_PX, MOST_REGIONS, find_borders, floor_outlines, open_rings, signed_area
from protocol.geometry import Array
from tests.unit.agent.floor_worlds import PROJECTION, VIEW, appearances, box, disc, seen, upright

NADIR = np.rint(VIEW.nadir_px).astype(int)


def squares(*sides_px: int) -> NDArray[np.uint8]:
    """Return the mask of squares round the robot, 200 pixels from it, at even distances."""
    mask = np.zeros(VIEW.valid.shape, np.uint8)
    for index, side in enumerate(sides_px):
        turn = 2.0 * np.pi * index / len(sides_px)
        u, v = NADIR + np.rint(200.0 * np.array([np.cos(turn), np.sin(turn)])).astype(int)
        mask[v : v + side, u : u + side] = 1
    return mask


def ring(near_m: float, far_m: float) -> NDArray[np.uint8]:
    return ((VIEW.range_m > near_m) & (VIEW.range_m < far_m)).astype(np.uint8)


def outline_of(mask: NDArray[np.uint8]) -> Array:
    (outline,) = floor_outlines(find_borders(mask, VIEW.nadir_px, 25.0), VIEW, PROJECTION)
    return outline


def turns(polygon: Array) -> Array:
    """Return twice the area of the triangle at every corner: positive where the border turns left."""
    edge = np.roll(polygon, -1, axis=0) - polygon
    following = np.roll(edge, -1, axis=0)
    return np.asarray(edge[:, 0] * following[:, 1] - edge[:, 1] * following[:, 0])


def test_a_wall_all_round_is_opened_behind_the_robot() -> None:
    wall = ring(0.8, 1.0)
    opened = open_rings(wall, VIEW)
    bearing = np.abs(VIEW.bearing_rad[(wall > 0) & (opened == 0)])
    assert bearing.size > 0
    assert bearing.min() > np.pi - 0.05
    u, v = NADIR
    assert find_borders(wall, VIEW.nadir_px, 25.0).numbers[v, u] == 1  # closed, it takes the robot for part of it
    assert find_borders(opened, VIEW.nadir_px, 25.0).numbers[v, u] == 0


def test_what_does_not_go_all_round_is_not_cut() -> None:
    behind = seen(upright(-box(0.8, 1.0, 0.2), 0.1))
    assert behind.any()
    assert (open_rings(behind, VIEW) == behind).all()
    assert not open_rings(np.zeros_like(behind), VIEW).any()


def test_a_thing_behind_the_robot_is_not_cut_with_the_wall_beyond_it() -> None:
    thing = seen(upright(-box(0.4, 0.5, 0.1), 0.1))
    opened = open_rings(thing | ring(1.5, 1.8), VIEW)
    assert (opened[thing > 0] == 1).all()
    assert len(find_borders(opened, VIEW.nadir_px, 25.0)) == 2


def test_regions_are_numbered_from_the_largest() -> None:
    mask = squares(8, 24, 16)
    borders = find_borders(mask, VIEW.nadir_px, 25.0)
    assert [np.count_nonzero(borders.numbers == number) for number in (1, 2, 3)] == [24**2, 16**2, 8**2]
    assert borders.compact == [True, True, True]
    assert ((borders.numbers > 0) == (mask > 0)).all()


def test_specks_are_dropped() -> None:
    borders = find_borders(squares(24, 5), VIEW.nadir_px, 25.0)  # through pixel centres, the area of the second is 16
    assert len(borders) == 1
    assert np.count_nonzero(borders.numbers) == 24**2


def test_an_empty_mask_has_no_regions() -> None:
    borders = find_borders(squares(), VIEW.nadir_px, 25.0)
    assert len(borders) == 0
    assert floor_outlines(borders, VIEW, PROJECTION) == []
    assert borders.near(np.array([[10.0, 10.0]])).tolist() == [0]


def test_of_too_many_regions_the_largest_are_kept() -> None:
    borders = find_borders(squares(*([8] * 30 + [12] * 30)), VIEW.nadir_px, 25.0)
    assert len(borders) == MOST_REGIONS
    assert [len(border) for border in borders.pixels] == [4 * 11] * 30 + [4 * 7] * (MOST_REGIONS - 30)


def test_holes_are_part_of_a_region() -> None:
    mask = squares(24)
    whole = mask.copy()
    mask[NADIR[1] + 10 : NADIR[1] + 14, NADIR[0] + 210 : NADIR[0] + 214] = 0
    assert (find_borders(mask, VIEW.nadir_px, 25.0).numbers == whole).all()


def test_corners_on_the_border_and_a_little_outside_lie_on_the_region() -> None:
    borders = find_borders(squares(24), VIEW.nadir_px, 25.0)
    u, v = NADIR + np.array([200, 0])
    points = [(u, v), (u - MARGIN_PX + 0.3, v + 5), (u - MARGIN_PX - 1, v + 5), (-1, 5), (5, 1e6)]
    assert borders.near(np.array(points)).tolist() == [1, 1, 0, 0, 0]


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_outline_of_a_compact_thing_is_its_shadow_convex_and_counter_clockwise(side: float) -> None:
    crate = upright(side * box(0.8, 0.9, 0.1), 0.1)
    outline = outline_of(seen(crate))
    assert (turns(outline) > 0.0).all()
    shadow = appearances(crate)
    assert outline.min(axis=0) == pytest.approx(shadow.min(axis=0), abs=0.02)
    assert outline.max(axis=0) == pytest.approx(shadow.max(axis=0), abs=0.02)


def test_outlines_end_where_the_view_does() -> None:
    mask = np.zeros(VIEW.valid.shape, np.uint8)
    mask[NADIR[1] - 60 : NADIR[1] + 60, NADIR[0] + 230 :] = 1
    assert not VIEW.valid[mask > 0].all()
    range_m = np.hypot(*outline_of(mask).T)
    assert range_m.max() == pytest.approx(VIEW.reach_m)
    assert range_m.min() < 0.8 * VIEW.reach_m


def test_a_corner_of_two_walls_keeps_its_bare_inside() -> None:
    walls = seen(upright(box(0.5, 1.2, 0.05), 0.0)) | seen(upright([(1.1, -0.05), (1.2, -0.05), (1.2, 0.9), (1.1, 0.9)], 0.0))
    borders = find_borders(walls, VIEW.nadir_px, 25.0)
    assert borders.compact == [False]
    (outline,) = floor_outlines(borders, VIEW, PROJECTION)
    assert (turns(outline) < 0.0).any()
    assert signed_area(outline) == pytest.approx(0.7 * 0.1 + 0.1 * 0.85, rel=0.15)


def test_every_region_has_its_outline_in_order() -> None:
    crate, post = seen(upright(box(0.6, 0.9, 0.2), 0.1)), seen(upright(disc(-0.7, 0.3, 0.05), 0.1))
    first, second = floor_outlines(find_borders(crate | post, VIEW.nadir_px, 25.0), VIEW, PROJECTION)
    assert first[:, 0].min() > 0.5
    assert second[:, 0].max() < -0.5


def test_an_area_is_positive_counter_clockwise() -> None:
    assert signed_area(box(1.0, 2.0, 0.5)) == pytest.approx(1.0)
    assert signed_area(box(1.0, 2.0, 0.5)[::-1]) == pytest.approx(-1.0)
