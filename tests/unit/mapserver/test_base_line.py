"""Base lines: whose they are, how far they reach, and what is behind them."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from mapserver.mapping.footprints.base_line import deepest_m, own_base, reaches_as_far, swept, way_behind
from mapserver.mapping.views.silhouette import Silhouette
from protocol.geometry import Array, Pose2
from tests.unit.mapserver.worlds import CAMERA_HEIGHT_M, rectangle, smear_of

EYE = Pose2(-0.8, 0.0, 0.0)
LINE = np.array([[-0.1, y_m] for y_m in np.linspace(-0.1, 0.1, 21)])  # the side of the box that faces the eye
BOX = rectangle(0.0, 0.0, 0.2, 0.2)


def seen(base_m: Array, weight: float = 0.5) -> Silhouette:
    return Silhouette(np.array(EYE[:2]), CAMERA_HEIGHT_M, shapely.Polygon(smear_of(base_m, 0.15, EYE)), weight)


def test_a_base_line_that_views_show_is_their_thing_s_own() -> None:
    views = [seen(BOX)]
    assert own_base(views, LINE) == (views, LINE)


def test_a_base_line_that_hardly_any_view_shows_is_another_thing_s() -> None:
    views = [seen(BOX), seen(BOX + np.array([0.0, 1.0]), weight=0.02)]
    kept, base_m = own_base(views, LINE + np.array([0.0, 1.0]))
    assert kept == views
    assert len(base_m) == 0


def test_a_view_of_something_else_is_left_out() -> None:
    view = seen(BOX)
    kept, base_m = own_base([view, seen(BOX + np.array([0.0, 1.0]))], LINE)
    assert kept == [view]
    assert base_m is LINE


def test_the_wall_behind_a_thing_is_not_what_the_thing_stands_on() -> None:
    wall = LINE + np.array([0.5, 0.0])
    thing_and_wall = seen(rectangle(0.3, 0.0, 0.8, 0.2))
    assert len(own_base([thing_and_wall], wall)[1]) == 0


@pytest.mark.parametrize(("step_m", "same"), [(0.02, True), (0.1, False)])
def test_a_base_line_that_has_grown_reaches_farther(step_m: float, same: bool) -> None:
    grown = np.vstack([LINE, LINE[-1] + np.array([0.0, step_m])])
    assert reaches_as_far(grown, LINE) == same
    assert not reaches_as_far(LINE, np.empty((0, 2)))


def test_behind_is_away_from_who_sees_it() -> None:
    assert way_behind(LINE, [seen(BOX)]) == pytest.approx([1.0, 0.0])


def test_a_swept_line_covers_what_lies_on_its_way_and_nothing_else() -> None:
    line = np.zeros((9, 9), np.uint8)
    line[2:7, 4] = 1
    covered = swept(line, np.array([1.0, 0.0]), 3)
    assert covered[2:7, 4:8].all()
    assert covered.sum() == 20


def test_behind_a_straight_base_line_a_thing_may_be_as_deep_as_that_is_long() -> None:
    assert deepest_m(LINE) == pytest.approx(0.2)


@pytest.mark.parametrize("side_m", [0.1, 0.2, 0.4])
def test_a_square_seen_edge_on_and_a_cylinder_are_allowed_to_be_whole_but_not_much_deeper(side_m: float) -> None:
    along = np.linspace(0.0, side_m, 41)
    corner = np.concatenate([np.stack([along, 0.0 * along], axis=-1), np.stack([0.0 * along, along], axis=-1)])
    assert side_m <= deepest_m(corner) < 1.2 * side_m + 0.02
    turn = np.linspace(0.0, np.pi, 41)
    arc = 0.5 * side_m * np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    assert 0.5 * np.sqrt(2.0) * side_m <= deepest_m(arc) < 0.9 * side_m + 0.02
