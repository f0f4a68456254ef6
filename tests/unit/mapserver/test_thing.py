"""When one thing belongs in the map."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from numpy.typing import NDArray

from mapserver.mapping.footprints.prism import Footprint
from mapserver.mapping.things.thing import MOST_HEIGHTS, REFIT_NS, SHOWN_BELIEF, SURE_BELIEF, Thing
from mapserver.mapping.views.silhouette import SeenHeight, Silhouette
from protocol.geometry import Array, Pose2
from tests.unit.mapserver.worlds import CAMERA_HEIGHT_M, rectangle, smear_of

HEIGHT_M = 0.25
BASE_LINE_M = np.stack([np.linspace(0.0, 0.2, 21), np.zeros(21)], axis=1)


def nowhere_bare(x_m: Array, y_m: Array) -> NDArray[np.bool_]:
    return np.zeros((len(y_m), len(x_m)), np.bool_)


def doubted(observations: int, told: int) -> Thing:
    """Return a thing with a base line on the map that is hardly believed in, seen so often, its height told so often."""
    base = shapely.box(0.0, 0.0, 0.2, 0.2)
    thing = Thing(0, Footprint(base, np.array([0.1, 0.1]), np.zeros((2, 2))), np.zeros(2), 0.1, 0)
    thing.belief, thing.observations, thing.base_m = 2.0 * SHOWN_BELIEF, observations, BASE_LINE_M
    thing.seen_by = {"r1", "r2"}
    thing.heights = [SeenHeight(0.1, 1.0)] * told
    return thing


def seen_from_ahead(far_m: float) -> Thing:
    """Return such a thing with one view of it, that shows it from its base line to so far behind."""
    thing = doubted(12, 12)
    thing.views.append(Silhouette(np.array([0.1, -0.8]), CAMERA_HEIGHT_M, shapely.box(0.0, 0.0, 0.2, far_m), 0.5))
    return thing


@pytest.mark.parametrize(("observations", "told", "is_shown"), [(5, 5, True), (12, 2, False), (12, 3, True), (2000, MOST_HEIGHTS, True)])
def test_what_is_doubted_is_shown_only_where_its_views_tell_its_height(observations: int, told: int, is_shown: bool) -> None:
    assert doubted(observations, told).is_shown() == is_shown


def test_what_one_robot_alone_has_seen_needs_twice_the_looks() -> None:
    thing = doubted(5, 5)
    thing.seen_by = {"r1"}
    assert not thing.is_shown()
    thing.observations = 6
    assert thing.is_shown()


def test_what_is_missed_more_than_half_as_often_as_seen_is_not_in_the_map() -> None:
    thing = doubted(10, 10)
    thing.farthest_m = 1.0
    for _ in range(5):
        thing.miss(1e-3, 0.9)
    thing.miss(1e-3, 1.1)  # from where it was never seen
    assert thing.is_shown()
    thing.miss(1e-3, 0.9)
    assert not thing.is_shown()


def test_a_sliver_without_a_base_line_is_not_in_the_map() -> None:
    thing = doubted(12, 12)
    thing.belief = SURE_BELIEF + 0.1
    thing.shape = thing.shape._replace(base=shapely.box(0.0, 0.0, 0.03, 0.06))
    assert thing.is_shown()
    thing.base_m = BASE_LINE_M[:12]
    assert not thing.is_shown()


@pytest.mark.parametrize(("seen_m", "is_shown"), [(0.0, False), (HEIGHT_M, True)])
def test_what_most_views_show_too_short_for_its_height_lies_flat(seen_m: float, is_shown: bool) -> None:
    box = rectangle(0.1, 0.1, 0.2, 0.2)
    thing = doubted(12, 12)
    thing.height_m = HEIGHT_M
    for eye in (Pose2(-0.8, 0.1, 0.0), Pose2(0.1, -0.8, 0.0), Pose2(1.0, 0.1, 0.0)):
        thing.views.append(Silhouette(np.array(eye[:2]), CAMERA_HEIGHT_M, shapely.Polygon(smear_of(box, seen_m, eye)), 0.5))
    thing.fit(nowhere_bare)
    assert thing.is_shown() == is_shown


@pytest.mark.parametrize(("away_m", "is_shown"), [(0.0, True), (0.5, False)])
def test_what_stands_beside_its_base_line_is_not_in_the_map(away_m: float, is_shown: bool) -> None:
    thing = seen_from_ahead(0.5)
    thing.base_m = BASE_LINE_M + away_m
    thing.fit(nowhere_bare)
    assert thing.is_shown() == is_shown


@pytest.mark.parametrize(("grown_m", "is_stale"), [(0.01, False), (0.1, True)])
def test_the_footprint_follows_a_base_line_that_has_grown(grown_m: float, is_stale: bool) -> None:
    thing = seen_from_ahead(0.2)
    thing.fit(nowhere_bare)
    thing.stand_on(BASE_LINE_M + grown_m)
    assert thing.is_stale == is_stale


def test_what_has_no_base_line_on_the_map_is_shown_once_it_is_surely_believed_in() -> None:
    thing = doubted(12, 12)
    thing.base_m = np.empty((0, 2))
    assert not thing.is_shown()
    thing.belief = SURE_BELIEF + 0.1
    assert thing.is_shown()


def test_what_is_in_the_map_rests_between_two_fits_and_what_is_not_yet_there_does_not() -> None:
    thing, guess = seen_from_ahead(0.4), seen_from_ahead(0.4)
    guess.belief = 0.0
    for each, later_ns, is_due in ((thing, REFIT_NS - 1, False), (thing, REFIT_NS, True), (guess, 1, True)):
        each.seen_ns = 1_000_000_000
        each.fit(nowhere_bare)
        assert not each.is_due()
        each.seen_ns += later_ns
        each.is_stale = True
        assert each.is_due() == is_due
