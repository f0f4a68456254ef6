"""What is told of every region: its motion, height, flatness, base, and whether it is two things."""

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from agent.slam.feature_tracks import Tracks, join, no_tracks
from agent.slam.region_labels import LAST_LABEL
from agent.slam.regions import LiesFlat, SeenRegion, describe
from agent.vision.hull import centre_of_polygon
from agent.vision.outlines import Borders, find_borders, signed_area
from protocol.geometry import Array
from tests.unit.agent.floor_worlds import PROJECTION, VIEW, appearances, box, seen, upright, watched

PIXEL_M = 0.0125  # of floor that one pixel covers, a metre away: 0.5 m * (1 + 2^2) / 200
CRATE = upright(box(0.8, 0.9, 0.1), 0.1)
LABEL = 5


def unknown(outline_m: Array) -> None:
    """Tell nothing of an outline."""


def described(mask: NDArray[np.uint8], tracks: Tracks, lies_flat: LiesFlat = unknown) -> list[SeenRegion]:
    borders = find_borders(mask, VIEW.nadir_px, 25.0)
    assert len(borders) == 1
    return describe(borders, np.array([LABEL], np.int32), lies_flat, tracks, VIEW, PROJECTION)


def test_corners_at_rest_make_a_static_region_as_high_as_its_top() -> None:
    (region,) = described(seen(CRATE), watched(CRATE, LABEL))
    assert (region.label, region.motion, region.flat) == (LABEL, "static", False)
    assert region.height_m == pytest.approx(0.1)


def test_one_wrong_corner_does_not_make_a_thing_higher() -> None:
    points = np.concatenate([np.repeat(CRATE, 3, axis=0), [(0.85, 0.0, 0.3)]])
    (region,) = described(seen(CRATE), watched(points, LABEL))
    assert region.height_m == pytest.approx(0.1)


def test_corners_that_move_along_make_a_moving_region_of_no_known_height() -> None:
    (region,) = described(seen(CRATE), watched(CRATE, LABEL, along=True))
    assert (region.motion, region.height_m) == ("moving", None)


def test_the_greater_part_of_the_corners_decides() -> None:
    still, moving = watched(CRATE, LABEL), watched(CRATE, LABEL, along=True)
    assert described(seen(CRATE), join(still, moving.select(np.arange(3))))[0].motion == "static"
    assert described(seen(CRATE), join(moving, still.select(np.arange(3))))[0].motion == "moving"


def test_nothing_is_known_with_two_corners_or_with_those_of_others() -> None:
    two = watched(CRATE, LABEL).select(np.arange(2))
    for tracks in (no_tracks(), two, join(two, watched(CRATE, LABEL + 1))):
        (region,) = described(seen(CRATE), tracks)
        assert (region.motion, region.height_m, region.flat) == ("unknown", None, False)


def test_a_region_without_area_is_left_out() -> None:
    u, v = (int(place) for place in VIEW.nadir_px)
    for compact in (True, False):
        border = np.array([[u, v - 40], [u + 1, v - 40]], np.int32)
        borders = Borders([border], [compact], np.zeros(VIEW.range_m.shape, np.uint8), [border.astype(np.float64)])
        assert describe(borders, np.array([LABEL], np.int32), unknown, no_tracks(), VIEW, PROJECTION) == []


def test_what_looks_like_the_floors_grain_and_has_no_corners_is_flat() -> None:
    (region,) = described(seen(upright(box(0.40, 0.44, 0.02), 0.0)), no_tracks())
    assert (region.motion, region.flat) == ("unknown", True)


@pytest.mark.parametrize("flat", [True, False])
def test_what_two_views_prove_goes_before_what_a_shape_suggests(flat: bool) -> None:
    for footprint in (box(0.40, 0.44, 0.02), box(0.40, 0.60, 0.1)):
        assert described(seen(upright(footprint, 0.0)), no_tracks(), lambda _: flat)[0].flat == flat


def test_corners_go_before_what_two_views_prove() -> None:
    assert not described(seen(CRATE), watched(CRATE, LABEL), lambda _: True)[0].flat


def test_a_marking_is_flat() -> None:
    marking = np.concatenate([upright(box(0.8, 1.0, 0.1), 0.0), [(0.9, 0.0, 0.0)]])
    (region,) = described(seen(marking), watched(marking, LABEL))
    assert (region.motion, region.flat, region.height_m) == ("static", True, 0.0)


def test_an_outline_is_the_shadow_of_the_thing_from_the_camera() -> None:
    (region,) = described(seen(CRATE), watched(CRATE, LABEL))
    shadow = appearances(CRATE)
    assert region.outline_m[:, 0].min() == pytest.approx(0.8, abs=PIXEL_M)
    assert region.outline_m[:, 0].max() == pytest.approx(shadow[:, 0].max(), abs=1.5 * PIXEL_M)
    assert region.centre_m == pytest.approx(centre_of_polygon(region.outline_m))


def test_a_region_that_shows_the_top_only_is_brought_down_to_the_floor() -> None:
    top = CRATE[4:]  # appears from 1.0 m on, and stands from 0.8 m on
    (region,) = described(seen(top), watched(np.repeat(top, 2, axis=0), LABEL))
    assert region.outline_m[:, 0].min() == pytest.approx(0.8, abs=PIXEL_M)
    assert signed_area(region.outline_m) > 0.0
    assert region.height_m == pytest.approx(0.1)


def test_a_thing_whose_base_another_one_hides_begins_where_it_is_seen() -> None:
    top, front = CRATE[4:], upright(box(0.7, 0.95, 0.1), 0.0)
    borders = find_borders(seen(top) | seen(front), VIEW.nadir_px, 25.0)
    farther = int(np.argmin([pixels[:, 1].mean() for pixels in borders.pixels]))
    labels = np.where(np.arange(len(borders)) == farther, LABEL, LABEL + 1).astype(np.int32)
    regions = describe(borders, labels, unknown, watched(np.repeat(top, 2, axis=0), LABEL), VIEW, PROJECTION)
    (region,) = (region for region in regions if region.label == LABEL)
    assert region.outline_m[:, 0].min() == pytest.approx(1.0, abs=PIXEL_M)
    assert region.height_m == pytest.approx(0.1)


def test_a_wall_around_the_robot_leaves_the_floor_before_it_bare() -> None:
    turns = np.linspace(-2.0, 2.0, 15)
    feet = np.stack([np.cos(turns), np.sin(turns), np.zeros_like(turns)], axis=-1)
    tops = feet + np.array([0.0, 0.0, 0.15])  # they appear from 1.43 m on
    wall = ((VIEW.range_m > 1.4) & (VIEW.range_m < 1.8) & (np.abs(VIEW.bearing_rad) < 2.0)).astype(np.uint8)
    (region,) = described(wall, watched(np.repeat(tops, 2, axis=0), LABEL))
    assert region.motion == "static"
    assert cv2.pointPolygonTest(region.outline_m.astype(np.float32)[:, None], (0.6, 0.0), False) < 0.0
    assert cv2.pointPolygonTest(region.outline_m.astype(np.float32)[:, None], (1.6, 0.0), False) > 0.0


def test_two_things_in_one_region_are_parted_and_the_one_behind_mirrors_the_label() -> None:
    behind = upright(box(1.3, 1.4, 0.1), 0.15)
    both = seen(np.concatenate([CRATE, behind]))
    first, second = described(both, join(watched(CRATE, LABEL), watched(behind, LABEL)))
    assert (first.label, second.label) == (LABEL, 2 * LAST_LABEL + 1 - LABEL)
    assert (first.motion, second.motion) == ("static", "static")
    begins_m = np.hypot(1.3, 0.1)
    assert first.outline_m[:, 0].max() == pytest.approx(begins_m, abs=PIXEL_M)
    assert second.outline_m[:, 0].min() == pytest.approx(begins_m, abs=PIXEL_M)
    assert (first.height_m, second.height_m) == pytest.approx((0.1, 0.15))
