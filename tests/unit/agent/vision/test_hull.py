"""Convex hulls of corrected points, and object centres by Eq. 8."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from agent.vision.hull import centre_of_polygon, centre_of_region, convex_hull, hulls_by_label, overlap
from protocol.errors import GeometryError
from protocol.geometry import Array

SQUARE = np.array([[0.0, 0.0], [0.2, 0.0], [0.2, 0.2], [0.0, 0.2]])


def signed_area(polygon: Array) -> float:
    x, y = polygon.T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


def test_inner_points_are_left_out_and_the_rest_runs_counter_clockwise() -> None:
    hull = convex_hull(np.concatenate([SQUARE[::-1], [[0.1, 0.1], [0.05, 0.15]]]))
    assert sorted(hull.tolist()) == sorted(SQUARE.tolist())
    assert signed_area(hull) == pytest.approx(0.04)


def test_points_nowhere_on_the_floor_are_left_out() -> None:
    assert len(convex_hull(np.concatenate([SQUARE, [[np.nan, np.nan]]]))) == 4


def test_few_points_are_their_own_outline() -> None:
    assert convex_hull(np.empty((0, 2))).shape == (0, 2)
    assert convex_hull(np.full((3, 2), np.nan)).shape == (0, 2)
    assert convex_hull(np.array([[0.3, 0.1]])).tolist() == [[0.3, 0.1]]
    assert sorted(convex_hull(np.array([[0.0, 0.0], [1.0, 1.0], [0.5, 0.5]])).tolist()) == [[0.0, 0.0], [1.0, 1.0]]


@pytest.mark.parametrize(("apart", "common"), [(0.0, 0.04), (0.15, 0.01), (0.25, 0.0)])
def test_polygons_have_in_common_what_lies_in_both(apart: float, common: float) -> None:
    assert overlap(SQUARE, SQUARE + np.array([apart, 0.0])) == pytest.approx(common, abs=1e-6)
    assert overlap(SQUARE[:2], SQUARE) == 0.0


def test_every_label_gets_its_own_hull_and_the_floor_none() -> None:
    points = np.concatenate([SQUARE, SQUARE + 1.0, [[9.0, 9.0], [np.nan, 0.0]]])
    hulls = hulls_by_label(points, np.array([1] * 4 + [7] * 4 + [0, 8]))
    assert sorted(hulls) == [1, 7]
    assert sorted(hulls[7].tolist()) == sorted((SQUARE + 1.0).tolist())


points = st.lists(st.tuples(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0)), min_size=3, max_size=40)


@given(points)
def test_no_point_lies_outside_the_hull(cloud: list[tuple[float, float]]) -> None:
    given_points = np.array(cloud)
    hull = convex_hull(given_points)
    edge = np.roll(hull, -1, axis=0) - hull
    offset = given_points[:, None] - hull
    assert (edge[:, 0] * offset[..., 1] - edge[:, 1] * offset[..., 0] > -1e-5).all()


def test_equation_8_counts_bright_pixels_only() -> None:
    picture = np.zeros((6, 8), np.uint8)
    picture[2:4, 1:6] = 7
    picture[5, 7] = 200  # brightness itself does not count
    # 10 pixels with mean (3, 2.5) and one at (7, 5)
    assert centre_of_region(picture) == pytest.approx([(10 * 3 + 7) / 11, (10 * 2.5 + 5) / 11])


def test_a_dark_region_has_no_centre() -> None:
    with pytest.raises(GeometryError, match="no pixel"):
        centre_of_region(np.zeros((4, 4), np.uint8))


def test_the_centre_of_a_polygon_is_that_of_its_area_not_of_its_vertices() -> None:
    # A 2 x 1 rectangle with a 1 x 1 square on its left half, vertices crowded in a corner.
    shape = np.array([[0, 0], [0.1, 0], [0.2, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]])
    shape += np.array([10.0, -5.0])
    assert centre_of_polygon(shape) == pytest.approx([10.0 + (2 * 1.0 + 1 * 0.5) / 3, -5.0 + (2 * 0.5 + 1 * 1.5) / 3])
    assert centre_of_polygon(shape[::-1]) == pytest.approx(centre_of_polygon(shape))


def test_a_line_and_a_point_have_their_middle() -> None:
    assert centre_of_polygon(np.array([[0.0, 0.0], [0.4, 0.2]])) == pytest.approx([0.2, 0.1])
    assert centre_of_polygon(np.array([[0.0, 0.0], [0.1, 0.05], [0.4, 0.2]])) == pytest.approx([0.2, 0.1])
    assert centre_of_polygon(np.array([[0.3, 0.1]])) == pytest.approx([0.3, 0.1])


@pytest.mark.parametrize("vertices", [np.empty((0, 2)), np.array([[0.0, np.nan]])])
def test_a_polygon_without_finite_vertices_has_no_centre(vertices: Array) -> None:
    with pytest.raises(GeometryError, match="finite vertices"):
        centre_of_polygon(vertices)


def test_both_forms_of_equation_8_agree_on_the_same_square() -> None:
    picture = np.zeros((40, 40), np.uint8)
    picture[10:20, 5:35] = 1
    corners = np.array([[4.5, 9.5], [34.5, 9.5], [34.5, 19.5], [4.5, 19.5]])  # outer borders of the pixels
    assert centre_of_region(picture) == pytest.approx(centre_of_polygon(corners))
