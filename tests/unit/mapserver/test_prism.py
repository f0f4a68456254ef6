"""Prisms: footprints from outlines and a height, whatever the side, and votes against views that are wrong."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest
import shapely
from numpy.typing import NDArray

from mapserver.mapping.footprints.prism import Ground, footprint
from mapserver.mapping.views.silhouette import SeenHeight, Silhouette, height_of, silhouettes_of
from protocol.geometry import Array, Pose2
from tests.unit.mapserver.worlds import CAMERA_HEIGHT_M, rectangle, smear_of

HEIGHT_M = 0.15
TURNED = Pose2(0.3, -0.2, 0.4)
BOX = TURNED.apply(rectangle(0.0, 0.0, 0.24, 0.20))
CYLINDER = np.array([[0.1 + 0.07 * math.cos(a), 0.07 * math.sin(a)] for a in np.linspace(0.0, 2.0 * math.pi, 40, endpoint=False)])
ALL_ROUND = [(0.3 + 0.9 * math.cos(a), -0.2 + 0.9 * math.sin(a)) for a in np.linspace(0.0, 2.0 * math.pi, 7)]
ONE_SIDE = [(-0.6, -0.5), (-0.7, -0.2), (-0.6, 0.1)]


def seen_from(eye_m: tuple[float, float], base_m: Array, height_m: float = HEIGHT_M, weight: float = 0.5) -> Silhouette:
    outline = shapely.Polygon(smear_of(base_m, height_m, Pose2(*eye_m, 0.0)))
    return Silhouette(np.array(eye_m), CAMERA_HEIGHT_M, outline, weight)


def base_of(views: Sequence[Silhouette], height_m: float | None) -> shapely.Polygon:
    found = footprint(views, height_m)
    assert found is not None
    return found.base


def iou(found: shapely.Polygon, base_m: Array) -> float:
    truth = shapely.Polygon(base_m)
    return float(found.intersection(truth).area / found.union(truth).area)


@pytest.mark.parametrize("base_m", [BOX, CYLINDER])
@pytest.mark.parametrize("eyes", [ALL_ROUND, ONE_SIDE])
def test_a_known_height_gives_the_whole_footprint_even_from_one_side(base_m: Array, eyes: Sequence[tuple[float, float]]) -> None:
    found = base_of([seen_from(eye, base_m) for eye in eyes], HEIGHT_M)
    assert iou(found, base_m) > 0.9 or (base_m is CYLINDER and eyes is ONE_SIDE and iou(found, base_m) > 0.85)
    assert found.centroid.distance(shapely.Polygon(base_m).centroid) < 0.01


def test_a_thing_of_unknown_height_is_about_as_deep_as_wide() -> None:
    box = rectangle(0.0, 0.0, 0.2, 0.2)
    low_x, low_y, high_x, high_y = base_of([seen_from((-0.8, 0.0), box)], None).bounds
    assert low_x == pytest.approx(-0.1, abs=0.01)
    assert high_y - low_y == pytest.approx(0.2, abs=0.03)
    assert 0.7 < (high_x - low_x) / (high_y - low_y) < 1.4


def test_a_minority_that_misses_part_of_the_thing_is_outvoted() -> None:
    good = [seen_from(eye, BOX) for eye in ALL_ROUND]
    part = [seen_from(eye, TURNED.apply(rectangle(0.06, 0.0, 0.10, 0.20))) for eye in ALL_ROUND[:2]]
    assert iou(base_of(good + part, HEIGHT_M), BOX) > 0.9


def test_a_minority_that_sees_two_things_as_one_is_outvoted() -> None:
    good = [seen_from(eye, BOX) for eye in ALL_ROUND]
    both = np.vstack([BOX, BOX + np.array([0.3, 0.1])])
    merged = [seen_from(eye, both) for eye in ALL_ROUND[:2]]
    assert iou(base_of(good + merged, HEIGHT_M), BOX) > 0.9


def nowhere_bare(x_m: Array, y_m: Array) -> NDArray[np.bool_]:
    return np.zeros((len(y_m), len(x_m)), np.bool_)


def test_floor_that_was_seen_bare_is_no_part_of_a_thing() -> None:
    box = rectangle(0.0, 0.0, 0.2, 0.2)
    view = seen_from((-0.8, 0.0), box, height_m=0.25)
    low = footprint([view], 0.1)
    carved = footprint([view], 0.1, Ground(lambda x_m, y_m: np.tile(x_m > 0.1, (len(y_m), 1)), np.empty((0, 2))))
    assert low is not None
    assert low.base.bounds[2] > 0.2  # told too low, it looks too deep
    assert carved is not None
    assert carved.base.bounds[2] == pytest.approx(0.1, abs=0.01)
    assert iou(carved.base, box) > 0.85


def test_a_thing_reaches_from_its_base_line_no_farther_than_that_is_long() -> None:
    line = np.array([[-0.1, y_m] for y_m in np.linspace(-0.1, 0.1, 21)])
    found = footprint([seen_from((-0.8, 0.0), rectangle(0.3, 0.0, 0.8, 0.2), 0.0)], 0.0, Ground(nowhere_bare, line))
    assert found is not None
    assert found.base.bounds[2] == pytest.approx(0.1, abs=0.02)


def test_a_base_line_that_the_views_miss_is_part_of_the_thing() -> None:
    line = np.array([[x_m, 0.1] for x_m in np.linspace(0.1, 0.3, 21)])
    found = footprint([seen_from((-0.8, 0.0), rectangle(0.0, 0.0, 0.2, 0.2))], HEIGHT_M, Ground(nowhere_bare, line))
    assert found is not None
    assert found.base.bounds[2] > 0.29


def test_a_base_line_in_pieces_is_all_of_one_thing() -> None:
    pieces = np.array([[x_m, 0.1 * side] for side in (-1, 1) for x_m in np.linspace(-0.1, 0.1, 21)])
    parted = Ground(lambda x_m, y_m: np.tile((np.abs(y_m) < 0.03)[:, None], (1, len(x_m))), pieces)  # as where a thing looks like the floor
    found = footprint([seen_from((-0.8, 0.0), rectangle(0.0, 0.09, 0.1, 0.02))], HEIGHT_M, parted)
    assert found is not None
    assert iou(found.base, rectangle(0.0, 0.0, 0.2, 0.2)) > 0.8


def test_a_view_that_shows_a_wall_as_well_does_not_count_where_others_show_the_thing_alone() -> None:
    line = np.array([[-0.1, y_m] for y_m in np.linspace(-0.1, 0.1, 21)])
    alone = seen_from((-0.8, 0.0), rectangle(0.0, 0.0, 0.2, 0.2), weight=0.1)
    with_wall = seen_from((-0.8, 0.0), np.vstack([rectangle(0.0, 0.0, 0.2, 0.2), rectangle(0.5, 0.5, 0.02, 2.0)]), weight=0.9)
    found = footprint([alone, with_wall], HEIGHT_M, Ground(nowhere_bare, line))
    assert found is not None
    assert iou(found.base, rectangle(0.0, 0.0, 0.2, 0.2)) > 0.9


def test_a_wall_goes_on_behind_its_base_line_where_the_floor_is_not_bare() -> None:
    line = np.array([[0.5, y_m] for y_m in np.linspace(-0.8, 0.8, 161)])
    seen = seen_from((-0.3, 0.0), rectangle(0.51, 0.0, 0.02, 1.6), 0.0)
    found = footprint([seen], 0.2, Ground(lambda x_m, y_m: np.tile(x_m < 0.49, (len(y_m), 1)), line))
    assert found is not None
    low_x, _, high_x, _ = found.base.bounds
    assert (low_x, high_x) == (pytest.approx(0.49, abs=0.02), pytest.approx(0.65, abs=0.02))


def test_there_is_no_wall_before_its_base_line_even_where_nobody_saw_the_floor_bare() -> None:
    line = np.array([[0.5, y_m] for y_m in np.linspace(-0.8, 0.8, 161)])
    found = footprint([seen_from((-0.3, 0.0), rectangle(0.51, 0.0, 0.02, 1.6), 0.0)], 0.2, Ground(nowhere_bare, line))
    assert found is not None
    low_x, _, high_x, _ = found.base.bounds
    assert (low_x, high_x) == (pytest.approx(0.49, abs=0.02), pytest.approx(0.65, abs=0.02))


def test_a_base_line_that_the_views_do_not_show_takes_no_thing_away() -> None:
    line = np.array([[0.6, y_m] for y_m in np.linspace(-0.1, 0.1, 21)])
    found = footprint([seen_from(eye, BOX) for eye in ALL_ROUND], HEIGHT_M, Ground(nowhere_bare, line + np.array([0.3, 0.5])))
    assert found is not None
    assert iou(found.base, BOX) > 0.9


def test_a_few_base_cells_are_no_base_line() -> None:
    speck = np.array([[-0.4, y_m] for y_m in np.linspace(0.0, 0.05, 6)])
    found = footprint([seen_from((-0.8, 0.0), rectangle(0.0, 0.0, 0.2, 0.2))], HEIGHT_M, Ground(nowhere_bare, speck))
    assert found is not None
    assert iou(found.base, rectangle(0.0, 0.0, 0.2, 0.2)) > 0.9


def test_a_height_that_puts_a_thing_beside_its_base_line_is_not_believed() -> None:
    box = rectangle(0.0, 0.0, 0.2, 0.2)
    line = np.array([[-0.1, y_m] for y_m in np.linspace(-0.1, 0.1, 21)])
    view = seen_from((-0.8, 0.0), box)
    found = footprint([view], 0.9 * CAMERA_HEIGHT_M, Ground(nowhere_bare, line))
    assert found is not None
    assert iou(found.base, box) > 0.6


def test_a_look_at_a_sliver_of_a_thing_does_not_count() -> None:
    good = seen_from(ALL_ROUND[0], BOX, weight=0.1)
    sliver = seen_from(ALL_ROUND[0], TURNED.apply(rectangle(0.1, 0.09, 0.02, 0.02)), weight=0.9)
    assert iou(base_of([good, sliver], HEIGHT_M), BOX) > 0.9


def test_a_sharper_view_counts_for_more() -> None:
    blurred = [seen_from(eye, BOX + 0.05, weight=0.1) for eye in ALL_ROUND[:3]]
    assert iou(base_of([*blurred, seen_from(ALL_ROUND[4], BOX, weight=0.9)], HEIGHT_M), BOX) > 0.8


def test_an_outline_that_falls_apart_into_two_things_gives_no_footprint() -> None:
    eye = np.array([-0.8, 0.0])
    things = [seen_from((-0.8, 0.0), rectangle(0.0, y, 0.1, 0.1)).outline for y in (-0.2, 0.2)]
    far_m = things[0].bounds[2]
    outline = shapely.union_all([*things, shapely.box(far_m - 0.02, -0.25, far_m, 0.25)])
    assert footprint([Silhouette(eye, CAMERA_HEIGHT_M, outline, 0.5)], HEIGHT_M) is None


def test_an_outline_too_short_for_its_height_stays_where_it_begins() -> None:
    box = rectangle(0.0, 0.0, 0.2, 0.2)
    found = base_of([seen_from((-0.8, 0.0), box, height_m=0.0)], 0.7 * CAMERA_HEIGHT_M)
    assert found.bounds[0] == pytest.approx(-0.1, abs=0.01)
    assert shapely.Polygon(box).buffer(0.01).covers(found)


def test_views_that_are_shifted_against_each_other_give_no_sliver() -> None:
    box = rectangle(0.0, 0.0, 0.08, 0.20)
    shifted = [seen_from((-0.8, 0.0), box + np.array([shift, 0.0])) for shift in (-0.07, 0.0, 0.07)]
    assert base_of(shifted, HEIGHT_M).area > 0.4 * 0.08 * 0.20


def test_views_that_disagree_say_by_how_much() -> None:
    agreed = footprint([seen_from(eye, BOX) for eye in ALL_ROUND], HEIGHT_M)
    shifted = footprint([seen_from(eye, BOX + np.array([0.04 * (-1) ** i, 0.0])) for i, eye in enumerate(ALL_ROUND[:4])], HEIGHT_M)
    assert agreed is not None
    assert shifted is not None
    assert np.trace(agreed.disagreement) < 0.01**2
    assert np.sqrt(shifted.disagreement[0, 0]) == pytest.approx(0.04, rel=0.25)


def test_a_silhouette_is_the_hull_of_base_and_stretched_top() -> None:
    square = shapely.box(1.0, -0.1, 1.2, 0.1)
    flat, half, tall = silhouettes_of([square] * 3, np.array([0.0, 0.25, 9.0]), np.zeros(2), 0.5)
    assert flat.equals(square)
    assert half.equals(shapely.Polygon([(1.0, -0.1), (1.0, 0.1), (2.0, -0.2), (2.4, -0.2), (2.4, 0.2), (2.0, 0.2)]).convex_hull)
    assert tall.bounds[2] == pytest.approx(1.2 * 20.0)


def test_the_height_is_told_by_two_views_and_more_by_the_sharper() -> None:
    assert height_of([]) is None
    assert height_of([SeenHeight(0.1, 1.0)]) is None
    assert height_of([SeenHeight(0.3, 0.1), SeenHeight(0.1, 0.9)]) == pytest.approx(0.1)


def test_corners_below_the_top_are_more_common_than_any_above_it() -> None:
    told = [0.05] * 5 + [0.12] * 6 + [0.17] * 7 + [0.45]
    assert height_of([SeenHeight(h, 0.5) for h in told]) == pytest.approx(0.17)
