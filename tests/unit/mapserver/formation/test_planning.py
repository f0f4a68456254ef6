"""Ways over the mapped floor, and the curves that they become."""

from __future__ import annotations

import math

import numpy as np
import pytest

from mapserver.formation.costmap import CostMap, Disc, cost_map
from mapserver.formation.floor import Bounds, Floor
from mapserver.formation.planning import Berth, Reach
from mapserver.formation.smoothing import smooth
from mapserver.formation.trail import STEP_M, Lane
from protocol.geometry import Array
from protocol.messages import FREE, OCCUPIED, UNKNOWN

BERTH = Berth(0.11, 0.35)
START_M, GOAL_M = np.array([0.5, 1.5]), np.array([3.5, 1.5])
BOUNDS = Bounds(0.0, 0.0, 4.0, 3.0)


def scene(*boxes: tuple[float, float, float, float], known: bool = True, bounds: Bounds | None = BOUNDS) -> CostMap:
    """Return a map of 4 x 3 m with boxes, each x_min, y_min, x_max, y_max [m]."""
    cells = np.full((300, 400), FREE if known else UNKNOWN, np.uint8)
    for x_min, y_min, x_max, y_max in boxes:
        cells[round(y_min * 100) : round(y_max * 100), round(x_min * 100) : round(x_max * 100)] = OCCUPIED
    return cost_map(Floor(cells, np.zeros(2), 0.01), bounds, np.array([START_M, GOAL_M]), [])


def way(on: CostMap) -> Array:
    route_m = Reach(on, START_M, BERTH).route(GOAL_M)
    assert route_m is not None
    return np.vstack([START_M, smooth(route_m, START_M[None], on, BERTH)])


def test_clearance_is_the_distance_to_the_nearest_edge() -> None:
    on = scene((2.0, 1.0, 2.2, 2.0))
    assert on.clearance_m(np.array([[1.755, 1.5], [2.1, 1.5], [0.055, 1.5], [9.0, 9.0]])) == pytest.approx(
        [0.24, 0.0, 0.05, 0.0], abs=0.011
    )


@pytest.mark.parametrize(("width_m", "clearance_m"), [(0.03, 0.7), (0.04, 0.24)])
def test_specks_are_not_in_the_way(width_m: float, clearance_m: float) -> None:
    on = scene((2.0, 1.5, 2.0 + width_m, 1.51), (2.46, 1.0, 2.6, 2.0))
    assert on.clearance_m(np.array([1.755, 1.505])) == pytest.approx(clearance_m, abs=0.011)


def test_discs_and_moving_things_keep_others_away() -> None:
    on = scene().with_discs([Disc(np.array([2.0, 1.5]), 0.1)])
    assert float(on.clearance_m(np.array([2.3, 1.5]))) == pytest.approx(0.2, abs=0.01)
    square_m = np.array([[1.9, 1.4], [2.1, 1.4], [2.1, 1.6], [1.9, 1.6]])
    person = cost_map(on.floor, BOUNDS, START_M[None], [square_m])
    assert float(person.clearance_m(np.array([2.6, 1.5]))) < 0.4, "more berth than for what stands"


@pytest.mark.parametrize("gap_m", [0.3, 0.4])
def test_the_way_leads_through_the_middle_of_a_gap(gap_m: float) -> None:
    on = scene((2.0, 0.0, 2.1, 1.0), (2.0, 1.0 + gap_m, 2.1, 3.0))
    points_m = way(on)
    inside = points_m[(points_m[:, 0] > 2.0) & (points_m[:, 0] < 2.1)]
    assert np.abs(inside[:, 1] - (1.0 + 0.5 * gap_m)).max() < 0.025
    assert on.clearance_m(points_m).min() > BERTH.least_m


def test_a_gap_too_narrow_for_the_body_is_no_way() -> None:
    on = scene((2.0, 0.0, 2.1, 1.4), (2.0, 1.6, 2.1, 3.0))
    assert Reach(on, START_M, BERTH).route(GOAL_M) is None
    assert math.isinf(Reach(on, START_M, BERTH).cost_to(GOAL_M))


def test_what_nobody_has_seen_may_be_crossed_but_known_floor_is_preferred() -> None:
    assert len(way(scene(known=False))) > 250
    cells = np.full((300, 400), FREE, np.uint8)
    cells[60:240, 100:300] = UNKNOWN
    route_m = Reach(cost_map(Floor(cells, np.zeros(2), 0.01), BOUNDS, START_M[None], []), START_M, BERTH).route(GOAL_M)
    assert route_m is not None
    assert np.abs(route_m[:, 1] - 1.5).max() > 0.8


def test_curves_bend_gently_and_keep_clear() -> None:
    on = scene((1.5, 1.0, 1.9, 1.8), (2.5, 1.4, 2.7, 2.6))
    points_m = way(on)
    lane = Lane.through(points_m)
    assert np.abs(lane.turns).max() < 1.0 / 0.15
    assert on.clearance_m(points_m).min() > 0.15
    assert np.hypot(*np.diff(points_m, axis=0).T) == pytest.approx(np.full(len(points_m) - 1, STEP_M), rel=0.05)


def test_a_curve_goes_on_in_the_direction_of_the_trail_before_it() -> None:
    on = scene()
    before_m = START_M + np.linspace(-0.39, 0.0, 40)[:, None] * math.sqrt(0.5)
    route_m = Reach(on, START_M, BERTH).route(GOAL_M)
    assert route_m is not None
    lane = Lane.through(np.vstack([before_m, smooth(route_m, before_m, on, BERTH)]))
    assert np.abs(np.diff(lane.headings_rad)).max() < 0.1


def test_a_body_that_stands_too_near_to_a_thing_can_leave() -> None:
    on = scene((0.57, 1.0, 0.8, 2.0))
    route_m = Reach(on, START_M, BERTH).route(np.array([0.3, 2.5]))
    assert route_m is not None


def test_a_goal_beside_a_thing_is_replaced_by_the_nearest_free_place() -> None:
    on = scene((3.45, 1.4, 3.6, 1.6))
    route_m = Reach(on, START_M, BERTH).route(np.array([3.4, 1.5]))
    assert route_m is not None
    assert 0.05 < math.dist(route_m[-1], (3.4, 1.5)) < 0.25


def test_without_bounds_there_is_open_floor_around_what_is_known() -> None:
    on = scene((0.0, 1.0, 4.0, 1.2), bounds=None)
    assert Reach(on, START_M, BERTH).route(np.array([0.5, 0.5])) is not None, "round the end of the wall, over floor that nobody has seen"
