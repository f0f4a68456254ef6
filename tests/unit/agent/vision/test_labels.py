"""Labels of what is not floor, and the region connection of Algorithm 1."""

from random import Random

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from agent.vision.hull import centre_of_region
from agent.vision.labels import connect_rectangles, label_regions

A, B, C = [0, 0, 10, 10], [8, 8, 10, 10], [16, 16, 10, 10]


def merged(rectangles: list[list[int]], gap_px: int = 0) -> list[list[int]]:
    found: list[list[int]] = connect_rectangles(rectangles, gap_px)[0].tolist()
    return found


def picture(*rectangles: list[int]) -> NDArray[np.uint8]:
    mask = np.zeros((60, 80), np.uint8)
    for x, y, width, height in rectangles:
        mask[y : y + height, x : x + width] = 255
    return mask


def test_two_that_overlap_become_the_box_round_both() -> None:
    assert merged([A, B]) == [[0, 0, 18, 18]]


def test_a_chain_whose_ends_do_not_touch_becomes_one_in_any_order() -> None:
    for order in ([A, B, C], [A, C, B], [B, A, C], [C, A, B]):
        assert merged(order) == [[0, 0, 26, 26]]


def test_one_inside_another_leaves_the_outer() -> None:
    assert merged([[2, 3, 4, 5], A]) == [A]


def test_what_is_apart_stays_apart() -> None:
    assert merged([C, A]) == [A, C]


def test_rectangles_that_share_a_border_but_no_pixel_are_apart_unless_a_gap_is_allowed() -> None:
    beside = [10, 0, 5, 10]
    assert merged([A, beside]) == [A, beside]
    assert merged([A, beside], gap_px=1) == [[0, 0, 15, 10]]


def test_a_gap_bridges_fewer_empty_columns_than_it_says() -> None:
    away = [13, 0, 5, 10]  # three empty columns
    assert merged([A, away], gap_px=3) == [A, away]
    assert merged([A, away], gap_px=4) == [[0, 0, 18, 10]]


def test_a_box_that_grew_swallows_what_it_now_covers() -> None:
    apart_from_both = [14, 0, 3, 3]  # touches neither A nor B, but lies in the box round them
    assert merged([A, B, apart_from_both]) == [[0, 0, 18, 18]]


def test_every_input_is_told_its_region() -> None:
    rectangles, region = connect_rectangles([C, A, [2, 2, 1, 1]])
    assert rectangles[region].tolist() == [C, A, A]


def test_nothing_connects_to_nothing() -> None:
    rectangles, region = connect_rectangles(np.empty((0, 4)))
    assert rectangles.shape == (0, 4)
    assert region.shape == (0,)


def test_a_staircase_of_two_hundred_is_one_region() -> None:
    steps = [[6 * i, 4 * i, 7, 5] for i in range(200)]
    assert merged(steps) == [[0, 0, 1201, 801]]


rectangle = st.tuples(st.integers(0, 60), st.integers(0, 60), st.integers(1, 25), st.integers(1, 25)).map(list)


@given(st.lists(rectangle, max_size=25), st.integers(0, 3), st.randoms(use_true_random=False))
def test_many_end_as_disjoint_boxes_that_enclose_their_members_whatever_the_order(
    rectangles: list[list[int]], gap_px: int, shuffler: Random
) -> None:
    boxes, region = connect_rectangles(rectangles, gap_px)
    cover = np.zeros((120, 120), np.int64)
    for x, y, width, height in boxes:
        cover[y : y + height, x : x + width] += 1
    assert cover.max(initial=0) <= 1
    for (x, y, width, height), (left, top, wide, high) in zip(rectangles, boxes[region], strict=True):
        assert left <= x <= x + width <= left + wide
        assert top <= y <= y + height <= top + high
    shuffler.shuffle(rectangles)
    assert merged(rectangles, gap_px) == boxes.tolist()


def test_a_picture_of_two_things_and_noise_has_two_labels() -> None:
    regions = label_regions(picture([5, 5, 10, 10], [40, 20, 20, 5], [30, 50, 1, 1]), min_area_px=4)
    assert len(regions) == 2
    assert regions.rectangles.tolist() == [[5, 5, 10, 10], [40, 20, 20, 5]]
    assert regions.corners_px[1].tolist() == [[40, 20], [60, 20], [60, 25], [40, 25]]
    assert regions.areas_px.tolist() == [100, 100]
    assert regions.centres_px.tolist() == [[9.5, 9.5], [49.5, 22.0]]
    assert regions.labels_at([[5.4, 14.4], [59.4, 20.0], [30.0, 50.0], [0.0, 0.0]]).tolist() == [1, 2, 0, 0]


def test_points_outside_the_picture_or_nowhere_are_floor() -> None:
    regions = label_regions(picture([0, 0, 80, 60]), min_area_px=1)
    assert regions.labels_at([[-0.6, 3.0], [79.6, 3.0], [3.0, 59.6], [np.nan, 3.0], [79.4, 59.4]]).tolist() == [0, 0, 0, 0, 1]


def test_components_whose_rectangles_overlap_share_a_label_but_not_the_floor_between() -> None:
    corner = picture([10, 10, 20, 2], [10, 10, 2, 20])  # an L, with a block inside its rectangle
    corner[20:25, 20:25] = 255
    regions = label_regions(corner, min_area_px=4)
    assert regions.rectangles.tolist() == [[10, 10, 20, 20]]
    assert np.array_equal(regions.image > 0, corner > 0)
    assert np.array_equal(regions.mask(1), corner[10:30, 10:30] > 0)
    assert regions.centres_px[0] == pytest.approx(centre_of_region(corner))


def test_an_empty_picture_has_no_labels() -> None:
    regions = label_regions(picture(), min_area_px=1)
    assert len(regions) == 0
    assert regions.labels_at([[3.0, 3.0]]).tolist() == [0]
    assert regions.centres_px.shape == (0, 2)
