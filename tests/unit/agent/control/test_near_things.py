"""What is remembered of the things around the robot."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from agent.control.borders import NEAR_M, SPACING_M, along_border, seen_borders
from agent.control.near_things import AT_REST_S, MOVING_S, ONE_THING_M, STATIC_S, TRODDEN_S, NearThings
from protocol.geometry import Pose2
from protocol.messages import Region
from tests.unit.agent.control.local_maps import HIDDEN_M, Motion, box, local_map, region, sighting

RADIUS_M = 0.075
AHEAD_M = 0.35  # of a box of 0.2 m: its near side is 0.25 m ahead


def nearest(near: NearThings, odom_from_body: Pose2) -> float:
    points = near.around(odom_from_body).points_m
    return float(np.hypot(*points.T).min(initial=math.inf))


@given(st.floats(0.02, 0.5), st.floats(0.02, 0.5))
def test_points_along_a_border_lie_close_together_and_on_it(width_m: float, depth_m: float) -> None:
    points = along_border(box(0.0, 0.0, width_m, depth_m))
    apart = np.hypot(*(np.roll(points, -1, axis=0) - points).T)
    assert apart.max() <= SPACING_M + 1e-9
    outside = np.abs(points) - (0.5 * width_m, 0.5 * depth_m)
    np.testing.assert_allclose(outside.max(axis=1), 0.0, atol=1e-9)


def test_a_sighted_robot_is_a_circle_of_its_size_that_moves() -> None:
    borders = seen_borders(local_map(0, sightings=[sighting(0.3, math.pi / 2)]), RADIUS_M)
    np.testing.assert_allclose(np.hypot(*(borders.points_m - (0.0, 0.3)).T), RADIUS_M)
    assert borders.moving.all()


def test_the_outline_of_a_sighted_robot_moves_as_well_and_a_thing_does_not() -> None:
    robot, thing = box(0.3, 0.0, 0.14, 0.14), box(-0.3, 0.0)
    borders = seen_borders(local_map(0, [region(robot), region(thing)], sightings=[sighting(0.3, 0.0)]), RADIUS_M)
    np.testing.assert_array_equal(borders.moving, borders.points_m[:, 0] > 0.0)


def test_things_far_away_are_left_out() -> None:
    assert not len(seen_borders(local_map(0, [region(box(2.0, 0.0))]), RADIUS_M).points_m)
    assert NEAR_M < 1.0


def test_things_stay_where_they_are_while_the_robot_moves() -> None:
    near = NearThings(RADIUS_M)
    near.see(local_map(0, [region(box(AHEAD_M, 0.0))]))
    assert nearest(near, Pose2.identity()) == pytest.approx(0.25, abs=1e-4)
    assert nearest(near, Pose2(0.1, 0.0, 0.0)) == pytest.approx(0.15, abs=1e-4)
    assert nearest(near, Pose2(0.0, 0.0, math.pi)) == pytest.approx(0.25, abs=1e-4)


def test_a_thing_is_remembered_once_the_own_body_hides_it() -> None:
    near = NearThings(RADIUS_M)
    near.see(local_map(0, [region(box(AHEAD_M, 0.0))]))
    closer = Pose2(0.1, 0.0, 0.0)
    near.see(local_map(100, odom_from_body=closer))
    assert nearest(near, closer) == pytest.approx(0.15, abs=0.001)


def test_a_thing_that_could_be_seen_and_is_not_is_gone() -> None:
    near = NearThings(RADIUS_M)
    near.see(local_map(0, [region(box(AHEAD_M, 0.0))]))
    near.see(local_map(100))
    assert nearest(near, Pose2.identity()) == math.inf


def test_nothing_is_forgotten_over_a_dropped_picture() -> None:
    near = NearThings(RADIUS_M)
    near.see(local_map(0, [region(box(AHEAD_M, 0.0))]))
    near.see(local_map(100, picture="dropped"))
    assert nearest(near, Pose2.identity()) == pytest.approx(0.25, abs=1e-4)


@pytest.mark.parametrize(("motion", "kept_s"), [("moving", MOVING_S), ("static", STATIC_S), ("unknown", STATIC_S)])
def test_what_is_hidden_is_forgotten_after_a_while(motion: Motion, kept_s: float) -> None:
    near = NearThings(RADIUS_M)
    near.see(local_map(0, [region(box(AHEAD_M, 0.0), motion)]))
    closer = Pose2(0.1, 0.0, 0.0)
    near.see(local_map(round(1e3 * kept_s), odom_from_body=closer))
    assert nearest(near, closer) < 0.2
    near.see(local_map(round(1e3 * kept_s) + 1, odom_from_body=closer))
    assert nearest(near, closer) == math.inf


def test_a_place_is_remembered_for_as_long_as_anything_seen_there() -> None:
    near = NearThings(RADIUS_M)
    thing, closer = box(AHEAD_M, 0.0), Pose2(0.1, 0.0, 0.0)
    hidden = closer.inverse().apply(thing)
    near.see(local_map(0, [region(thing)]))
    near.see(local_map(100, [region(hidden, "moving", label=2)], odom_from_body=closer))
    for stamp_ms in range(200, 2000, 100):
        near.see(local_map(stamp_ms, odom_from_body=closer))
    assert nearest(near, closer) == pytest.approx(0.15, abs=0.001)


@pytest.mark.parametrize(("rest_s", "kept_s"), [(AT_REST_S, MOVING_S), (AT_REST_S + 0.1, STATIC_S)])
def test_what_has_moved_is_taken_to_move_for_a_while(rest_s: float, kept_s: float) -> None:
    near = NearThings(RADIUS_M)
    last_ms = 1000 + round(1e3 * rest_s)
    for stamp_ms in range(0, last_ms + 1, 100):
        motion: Motion = "moving" if stamp_ms <= 1000 else "unknown"
        near.see(local_map(stamp_ms, [region(box(AHEAD_M, 0.0), motion)]))
    closer = Pose2(0.1, 0.0, 0.0)
    near.see(local_map(last_ms + round(1e3 * kept_s) + 1, odom_from_body=closer))
    assert nearest(near, closer) == math.inf


def test_a_robot_that_touches_a_thing_does_not_make_all_of_it_move() -> None:
    near = NearThings(RADIUS_M)
    thing = region(box(AHEAD_M, 0.0, 0.2, 0.6))
    for stamp_ms in range(0, 1001, 100):
        near.see(local_map(stamp_ms, [thing], sightings=[sighting(float(np.hypot(AHEAD_M, 0.3)), float(np.arctan2(0.3, AHEAD_M)))]))
    closer = Pose2(0.1, 0.0, 0.0)
    near.see(local_map(4000, odom_from_body=closer))
    assert nearest(near, closer) < 0.2


def test_what_shows_only_at_the_own_bodys_edge_is_no_thing() -> None:
    assert not len(seen_borders(local_map(0, [region(box(0.21, 0.0, 0.01, 0.01))]), RADIUS_M).points_m)


def test_what_flickers_is_no_thing_and_what_is_seen_again_is_one() -> None:
    near = NearThings(RADIUS_M)
    near.see(local_map(0))
    near.see(local_map(100))
    near.see(local_map(200, [region(box(0.4, 0.0), label=5)]))
    assert nearest(near, Pose2.identity()) == math.inf
    near.see(local_map(300, [region(box(-0.4, 0.0), label=6)]))
    assert nearest(near, Pose2.identity()) == math.inf
    near.see(local_map(400, [region(box(0.0, 0.5), label=6)]))  # known again by its label
    assert nearest(near, Pose2.identity()) == pytest.approx(0.4, abs=1e-3)
    near.see(local_map(500, [region(box(0.01, 0.49), label=9)]))  # known again by its place
    assert nearest(near, Pose2.identity()) == pytest.approx(0.39, abs=1e-3)


def test_a_sighted_robot_is_believed_in_at_once() -> None:
    near = NearThings(RADIUS_M)
    near.see(local_map(0))
    near.see(local_map(100))
    near.see(local_map(200, sightings=[sighting(0.4, 0.0)]))
    assert nearest(near, Pose2.identity()) == pytest.approx(0.4 - RADIUS_M, abs=1e-3)


def remembered_for_s(near: NearThings, *seen_later: Region) -> float:
    """Return for how long a small thing ahead is remembered that the own body hides, while something else is seen."""
    near.see(local_map(0, [region(box(0.25, 0.0, 0.02, 0.02))], odom_from_body=Pose2(-0.15, 0.0, 0.0)))
    near.see(local_map(100, [region(box(0.25, 0.0, 0.02, 0.02))], odom_from_body=Pose2(-0.15, 0.0, 0.0)))
    for tenths in range(round(10 * STATIC_S) + 2):
        near.see(local_map(200 + 100 * tenths, seen_later))
        if nearest(near, Pose2.identity()) > 0.12:
            return 0.1 * tenths
    return math.inf


def test_what_is_hidden_where_a_robot_has_been_is_not_remembered_for_long() -> None:
    for centre_m, lasts_s in (((0.1, 0.02), TRODDEN_S), ((0.1, 0.12), STATIC_S)):
        near = NearThings(RADIUS_M)
        near.note_robots(0, {"r2": np.array(centre_m)})
        assert remembered_for_s(near) == pytest.approx(lasts_s, abs=0.11)


def test_it_is_remembered_while_something_is_seen_behind_it() -> None:
    for place, lasts_s in ((box(0.24, 0.0, 0.08, 0.04), STATIC_S), (box(-0.24, 0.0, 0.08, 0.04), TRODDEN_S)):
        near = NearThings(RADIUS_M)
        near.note_robots(0, {"r2": np.array([0.1, 0.02])})
        assert remembered_for_s(near, region(place, label=2)) == pytest.approx(lasts_s, abs=0.21)


def test_a_thing_of_which_a_part_is_hidden_is_remembered_with_what_stands_beside_that() -> None:
    near, arrived = NearThings(RADIUS_M), Pose2(0.15, 0.0, 0.0)
    near.see(local_map(0, [region(box(0.4, 0.0, 0.2, 0.5))]))  # from 0.15 m ahead once the robot has arrived
    near.see(local_map(100, odom_from_body=arrived))
    kept_m = near.around(arrived).points_m
    assert np.hypot(*kept_m.T).max() < HIDDEN_M + ONE_THING_M
    assert np.abs(kept_m[:, 1]).max() > np.sqrt(HIDDEN_M**2 - 0.15**2) + 0.5 * ONE_THING_M  # hidden is less of its face
