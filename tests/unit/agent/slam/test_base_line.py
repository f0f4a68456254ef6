"""Where a thing begins is told from what is seen of its top."""

from __future__ import annotations

import numpy as np
import pytest

from agent.slam.base_line import Rig, base_share
from agent.slam.splitting import Corners
from protocol.geometry import Array
from tests.unit.agent.floor_worlds import HEIGHT_M, appearances, box, upright

RIG = Rig(HEIGHT_M, body_range_m=0.12, body_radius_m=0.08)


def top_of(near_m: float, far_m: float, height_m: float) -> Array:
    """Return the top's corners, (4, 3) [m], of a box ahead."""
    return upright(box(near_m, far_m, 0.1), height_m)[4:]


def corners_at(points: Array) -> Corners:
    return Corners(appearances(points), 1.0 - HEIGHT_M / (HEIGHT_M - points[:, 2]))


def share_of(outline: Array, corners: Array) -> float:
    """Return the share told for a region that shows points `outline` and has corners at points `corners`, both (n, 3) [m]."""
    return base_share(np.hypot(*appearances(outline).T), corners_at(corners), RIG)


@pytest.mark.parametrize("height_m", [0.1, 0.2, 0.24])
def test_a_top_with_corners_at_its_border_stands_nearer_by_its_stretch(height_m: float) -> None:
    top = top_of(0.6, 0.7, height_m)
    assert share_of(top, top) == pytest.approx(1.0 - height_m / HEIGHT_M)


def test_a_base_may_lie_under_the_own_bodys_shadow_but_not_in_the_body() -> None:
    for near_m, told in ((0.09, True), (0.07, False)):
        top = np.array([(near_m, 0.0, 0.2), (near_m + 0.1, 0.02, 0.2), (near_m + 0.1, -0.02, 0.2)])
        assert (share_of(top, np.repeat(top, 3, axis=0)) < 1.0) == told


def test_a_top_without_corners_at_its_border_is_told_by_those_at_its_back() -> None:
    top = top_of(0.6, 0.7, 0.2)
    assert share_of(top, np.repeat(top[1:3] - (0.02, 0.0, 0.0), 2, axis=0)) == pytest.approx(0.6)


def test_a_border_half_way_up_a_side_is_as_high_as_the_corners_next_to_it() -> None:
    upper_half = np.concatenate([upright(box(0.6, 0.7, 0.1), 0.1)[4:], top_of(0.6, 0.7, 0.2)])
    at_border = np.array([(0.6, y_m, 0.1) for y_m in (-0.05, 0.0, 0.05)])
    assert share_of(upper_half, np.concatenate([at_border, top_of(0.6, 0.7, 0.2)])) == pytest.approx(0.8)


def test_what_the_own_body_cuts_off_begins_where_it_is_seen() -> None:
    top = top_of(0.6, 0.7, 0.2)
    cut_off = RIG._replace(body_range_m=1.0)
    assert base_share(np.hypot(*appearances(top).T), corners_at(top), cut_off) == 1.0


def test_corners_on_a_side_that_is_seen_down_to_the_floor_tell_nothing() -> None:
    whole = upright(box(0.6, 0.7, 0.1), 0.2)
    on_side = np.array([(0.6, y_m, height_m) for y_m in (-0.05, 0.0, 0.05) for height_m in (0.06, 0.12, 0.18)])
    assert share_of(whole, on_side) == 1.0


def test_an_outline_long_enough_to_show_base_and_top_begins_where_it_is_seen() -> None:
    whole = upright(box(0.6, 0.7, 0.1), 0.2)
    assert share_of(whole, np.repeat(whole[5:7], 2, axis=0)) == 1.0


def test_a_base_much_nearer_than_what_is_seen_is_not_believed() -> None:
    top = top_of(0.7, 0.8, 0.3)
    assert share_of(top, top) == 1.0


def test_a_region_with_few_corners_or_with_some_on_the_floor_begins_where_it_is_seen() -> None:
    top = top_of(0.8, 0.9, 0.1)
    assert share_of(top, top[:2]) == 1.0
    assert share_of(top, np.concatenate([top, [(1.05, 0.0, 0.0)]])) == 1.0


def test_one_wrong_corner_of_many_does_not_hide_that_only_a_top_is_seen() -> None:
    top = top_of(0.8, 0.9, 0.1)
    many = np.concatenate([np.repeat(top, 3, axis=0), [(1.05, 0.0, 0.0)]])
    assert share_of(top, many) == pytest.approx(0.8)
