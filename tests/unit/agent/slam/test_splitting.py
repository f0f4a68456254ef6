"""Two things one behind the other, told apart by parallax."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.typing import ArrayLike

from agent.slam.splitting import Corners, Split, cut, split
from agent.vision.hull import convex_hull
from agent.vision.outlines import signed_area
from protocol.geometry import Array
from tests.unit.agent.floor_worlds import HEIGHT_M, appearances, box, upright

EYE = np.zeros(2)


def corners_of(*things: ArrayLike) -> Corners:
    points = np.concatenate([np.asarray(thing, dtype=np.float64) for thing in things])
    return Corners(appearances(points), 1.0 - HEIGHT_M / (HEIGHT_M - points[:, 2]))


def range_of(parted: Split | None) -> float:
    assert parted is not None
    return parted.range_m


def test_corners_stand_where_they_stand() -> None:
    points = upright(box(0.8, 0.9, 0.05), 0.1)
    assert corners_of(points).places_m() == pytest.approx(points[:, :2])


def test_a_thing_beyond_the_front_is_cut_off_where_it_begins_to_appear() -> None:
    front, behind = upright(box(0.8, 0.9, 0.05), 0.1), upright(box(1.3, 1.4, 0.05), 0.1)
    assert range_of(split(corners_of(front, behind), HEIGHT_M)) == pytest.approx(np.hypot(1.3, 0.05))


def test_a_lower_thing_behind_a_high_front_is_cut_off_though_they_appear_side_by_side() -> None:
    front, behind = upright(box(0.8, 0.9, 0.05), 0.2), upright(box(1.2, 1.3, 0.05), 0.1)
    assert range_of(split(corners_of(front, behind), HEIGHT_M)) == pytest.approx(np.hypot(1.2, 0.05))


def test_corners_belong_to_the_thing_they_stand_on_wherever_they_appear() -> None:
    front, behind = upright(box(0.8, 0.9, 0.05), 0.2), upright(box(1.2, 1.3, 0.05), 0.1)
    corners = corners_of(front, behind)
    parted = split(corners, HEIGHT_M)
    assert parted is not None
    assert np.hypot(*corners.appearances_m[~parted.behind].T).max() > parted.range_m
    assert parted.behind.tolist() == [False] * len(front) + [True] * len(behind)


def test_the_order_of_corners_does_not_matter() -> None:
    corners = corners_of(upright(box(1.3, 1.4, 0.05), 0.1), upright(box(0.8, 0.9, 0.05), 0.1))
    assert range_of(split(corners, HEIGHT_M)) == pytest.approx(np.hypot(1.3, 0.05))


def test_the_far_sides_of_one_box_are_no_other_thing() -> None:
    # An edge with three corners towards the robot; then both side edges, which begin on the floor; then the far top.
    edge = [(0.8, 0.0, 0.0), (0.8, 0.0, 0.1), (0.8, 0.0, 0.2)]
    sides = [(1.1, 0.3, 0.0), (1.1, -0.3, 0.0), (1.1, 0.3, 0.2), (1.1, -0.3, 0.2)]
    assert split(corners_of(edge, sides, [(1.4, 0.0, 0.2)]), HEIGHT_M) is None


def test_a_long_box_of_even_height_is_one_thing() -> None:
    tops = [(x, y, 0.1) for x in (0.8, 1.2, 1.6, 2.0) for y in (-0.05, 0.05)]
    assert split(corners_of([(0.8, -0.05, 0.0), (0.8, 0.05, 0.0)], tops), HEIGHT_M) is None


def test_two_corners_are_not_enough_for_a_front() -> None:
    front = [(0.8, 0.0, 0.0), (0.8, 0.0, 0.1)]
    behind = upright(box(1.3, 1.35, 0.05), 0.1)
    assert split(corners_of(front, behind), HEIGHT_M) is None
    assert split(corners_of(front, [(0.82, 0.0, 0.1)], behind), HEIGHT_M) is not None


def test_a_thing_without_corners_is_one() -> None:
    assert split(corners_of(np.zeros((0, 3))), HEIGHT_M) is None


def test_a_cut_by_hand() -> None:
    nearer, beyond = cut(box(1.0, 2.0, 0.5), EYE, 1.25)
    assert nearer[:, 0].max() == beyond[:, 0].min() == pytest.approx(1.25)
    assert (signed_area(nearer), signed_area(beyond)) == pytest.approx((0.25, 0.75))


def test_a_cut_before_or_behind_everything_leaves_all_on_one_side() -> None:
    outline = box(1.0, 2.0, 0.5)
    for range_m, whole in ((0.5, 1), (3.0, 0)):
        parts = cut(outline, EYE, range_m)
        assert parts[whole] == pytest.approx(outline)
        assert parts[1 - whole].shape == (0, 2)


def area(polygon: Array) -> float:
    return signed_area(polygon) if len(polygon) else 0.0


coordinates = st.floats(-1.0, 1.0)


@given(st.lists(st.tuples(coordinates, coordinates), min_size=3, max_size=12), st.floats(-2.0, 4.0), st.tuples(coordinates, coordinates))
def test_parts_keep_the_area_and_run_counter_clockwise(cloud: list[tuple[float, float]], range_m: float, eye: tuple[float, float]) -> None:
    outline = convex_hull(np.array(cloud))
    assume(len(outline) >= 3)
    nearer, beyond = cut(outline, np.array(eye), range_m)
    assert area(nearer) + area(beyond) == pytest.approx(area(outline), abs=1e-9)
    assert min(area(nearer), area(beyond)) >= -1e-6  # the hull itself is exact to single precision only
