"""What is remembered of the things around the robot."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from agent.control.borders import NEAR_M, SPACING_M, along_border, seen_borders
from agent.control.near_things import AT_REST_S, DOUBTFUL_S, LOCATED_S, ONE_THING_M, ROBOT_S, THING_S, NearThings
from protocol.geometry import Array, Pose2
from protocol.messages import Region
from tests.unit.agent.control.local_maps import HIDDEN_M, MS, Motion, box, local_map, region, sighting

RADIUS_M = 0.075
NOBODY = np.empty((0, 2))
AHEAD_M = 0.35  # of a box of 0.2 m: its near side is 0.25 m ahead
SMALL = box(AHEAD_M, 0.0, 0.12, 0.12)
ROUND_IT = np.array([(AHEAD_M, 0.0)])  # a robot there covers nearly all of it


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
    borders = seen_borders(local_map(0, sightings=[sighting(0.3, math.pi / 2)]), NOBODY, RADIUS_M)
    np.testing.assert_allclose(np.hypot(*(borders.points_m - (0.0, 0.3)).T), RADIUS_M)
    assert borders.moving.all()


def test_the_outline_of_a_sighted_robot_moves_as_well_and_a_thing_does_not() -> None:
    robot, thing = box(0.3, 0.0, 0.14, 0.14), box(-0.3, 0.0)
    borders = seen_borders(local_map(0, [region(robot), region(thing)], sightings=[sighting(0.3, 0.0)]), NOBODY, RADIUS_M)
    np.testing.assert_array_equal(borders.moving, borders.points_m[:, 0] > 0.0)


def test_things_far_away_are_left_out() -> None:
    assert not len(seen_borders(local_map(0, [region(box(2.0, 0.0))]), NOBODY, RADIUS_M).points_m)
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


@pytest.mark.parametrize(
    ("motion", "robots_m", "kept_s"), [("static", NOBODY, THING_S), ("moving", NOBODY, THING_S), ("static", ROUND_IT, ROBOT_S)]
)
def test_what_is_hidden_is_forgotten_after_a_while_and_a_robot_soon(motion: Motion, robots_m: Array, kept_s: float) -> None:
    near = NearThings(RADIUS_M)
    near.note_robots(0, "r1", {f"r{row + 2}": place_m for row, place_m in enumerate(robots_m)})
    near.see(local_map(0, [region(SMALL, motion)]))
    closer = Pose2(0.1, 0.0, 0.0)
    near.see(local_map(round(1e3 * kept_s), odom_from_body=closer))
    assert nearest(near, closer) < 0.2
    near.see(local_map(round(1e3 * kept_s) + 1, odom_from_body=closer))
    assert nearest(near, closer) == math.inf


def test_a_robot_is_known_by_its_place_only_while_that_is_told() -> None:
    near = NearThings(RADIUS_M)
    near.note_robots(0, "r1", {"r2": ROUND_IT[0]})
    near.see(local_map(round(1e3 * LOCATED_S) + 1, [region(SMALL)]))
    closer = Pose2(0.1, 0.0, 0.0)
    near.see(local_map(10_000, odom_from_body=closer))
    assert nearest(near, closer) < 0.2


def test_other_robots_are_where_the_map_server_saw_them() -> None:
    near = NearThings(RADIUS_M)
    near.note_robots(0, "r1", {"r1": np.zeros(2), "r2": ROUND_IT[0]})
    borders = near.robots(Pose2(0.1, 0.0, 0.0))
    np.testing.assert_allclose(np.hypot(*(borders.points_m - ROUND_IT + (0.1, 0.0)).T), RADIUS_M)
    assert borders.moving.all()


def test_only_what_was_seen_since_a_stamp_can_be_asked_for() -> None:
    near = NearThings(RADIUS_M)
    near.see(local_map(0, [region(box(AHEAD_M, 0.0))]))
    closer = Pose2(0.1, 0.0, 0.0)
    near.see(local_map(100, [region(box(-0.5, 0.0))], odom_from_body=closer))
    assert (near.around(closer).points_m[:, 0] > 0.0).any()
    assert not (near.around(closer, since_ns=100 * MS).points_m[:, 0] > 0.0).any()


def test_a_place_is_remembered_for_as_long_as_anything_seen_there() -> None:
    near = NearThings(RADIUS_M)
    thing, closer = box(AHEAD_M, 0.0), Pose2(0.1, 0.0, 0.0)
    hidden = closer.inverse().apply(thing)
    near.see(local_map(0, [region(thing)]))
    near.see(local_map(100, [region(hidden, "moving", label=2)], odom_from_body=closer))
    for stamp_ms in range(200, 2000, 100):
        near.see(local_map(stamp_ms, odom_from_body=closer))
    assert nearest(near, closer) == pytest.approx(0.15, abs=0.001)


@pytest.mark.parametrize(("rest_s", "moves"), [(AT_REST_S, True), (AT_REST_S + 0.1, False)])
def test_what_has_moved_is_taken_to_move_for_a_while(rest_s: float, moves: bool) -> None:
    near = NearThings(RADIUS_M)
    for stamp_ms in range(0, 1001 + round(1e3 * rest_s), 100):
        motion: Motion = "moving" if stamp_ms <= 1000 else "unknown"
        near.see(local_map(stamp_ms, [region(box(AHEAD_M, 0.0), motion)]))
    assert (near.around(Pose2.identity()).moving == moves).all()


def test_what_is_hidden_is_taken_to_stand_after_a_while() -> None:
    near = NearThings(RADIUS_M)
    near.see(local_map(0, [region(SMALL, "moving")]))
    for stamp_ms, moves in ((round(1e3 * AT_REST_S), True), (round(1e3 * AT_REST_S) + 1, False)):
        near.see(local_map(stamp_ms, odom_from_body=Pose2(0.1, 0.0, 0.0)))
        assert (near.around(Pose2(0.1, 0.0, 0.0)).moving == moves).all()


def test_a_robot_that_touches_a_thing_does_not_make_all_of_it_move() -> None:
    near = NearThings(RADIUS_M)
    thing = region(box(AHEAD_M, 0.0, 0.2, 0.6))
    for stamp_ms in range(0, 1001, 100):
        near.see(local_map(stamp_ms, [thing], sightings=[sighting(float(np.hypot(AHEAD_M, 0.3)), float(np.arctan2(0.3, AHEAD_M)))]))
    closer = Pose2(0.1, 0.0, 0.0)
    near.see(local_map(4000, odom_from_body=closer))
    assert nearest(near, closer) < 0.2


def test_what_shows_only_at_the_own_bodys_edge_is_no_thing() -> None:
    assert not len(seen_borders(local_map(0, [region(box(0.21, 0.0, 0.01, 0.01))]), NOBODY, RADIUS_M).points_m)


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


def test_an_outline_that_leads_under_the_own_body_is_believed_in_once_it_always_did() -> None:
    near = NearThings(RADIUS_M)
    for step in range(2):
        near.see(local_map(100 * step, [region(box(0.4, 0.0))]))
    nearer = [region(box(0.32, 0.0, 0.36, 0.2))]  # its near side is 0.14 m ahead
    for stamp_ms, least_m in ((200, HIDDEN_M - 0.01), (300, HIDDEN_M - 0.01), (400, 0.14)):
        near.see(local_map(stamp_ms, nearer))
        assert nearest(near, Pose2.identity()) == pytest.approx(least_m, abs=0.01)


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
    for tenths in range(round(10 * THING_S) + 2):
        near.see(local_map(200 + 100 * tenths, seen_later))
        if nearest(near, Pose2.identity()) > 0.12:
            return 0.1 * tenths
    return math.inf


def test_what_is_hidden_where_a_robot_has_been_is_not_remembered_for_long() -> None:
    for centre_m, lasts_s in (((0.1, 0.02), DOUBTFUL_S), ((0.1, 0.12), THING_S)):
        near = NearThings(RADIUS_M)
        near.note_robots(0, "r1", {"r2": np.array(centre_m)})
        near.note_robots(0, "r1", {"r2": np.ones(2)})
        assert remembered_for_s(near) == pytest.approx(lasts_s, abs=0.11)


def test_it_is_remembered_while_something_is_seen_behind_it() -> None:
    for place, lasts_s in ((box(0.24, 0.0, 0.08, 0.04), THING_S), (box(-0.24, 0.0, 0.08, 0.04), DOUBTFUL_S)):
        near = NearThings(RADIUS_M)
        near.note_robots(0, "r1", {"r2": np.array([0.1, 0.02])})
        near.note_robots(0, "r1", {"r2": np.ones(2)})
        assert remembered_for_s(near, region(place, label=2)) == pytest.approx(lasts_s, abs=0.21)


def test_a_thing_of_which_a_part_is_hidden_is_remembered_with_what_stands_beside_that() -> None:
    near, arrived = NearThings(RADIUS_M), Pose2(0.15, 0.0, 0.0)
    near.see(local_map(0, [region(box(0.4, 0.0, 0.2, 0.5))]))  # from 0.15 m ahead once the robot has arrived
    near.see(local_map(100, odom_from_body=arrived))
    kept_m = near.around(arrived).points_m
    assert np.hypot(*kept_m.T).max() < HIDDEN_M + ONE_THING_M
    assert np.abs(kept_m[:, 1]).max() > np.sqrt(HIDDEN_M**2 - 0.15**2) + 0.5 * ONE_THING_M  # hidden is less of its face


def remembered_for_s_after(near: NearThings, shown: int) -> float:
    """Return for how long a thing is remembered that shows in so many of ten pictures before the own body hides it."""
    thing, last = region(box(0.25, 0.0, 0.02, 0.02)), Pose2(-0.15, 0.0, 0.0)
    for step in range(10):
        near.see(local_map(100 * step, [thing] if step >= 10 - shown else (), odom_from_body=last))
    for tenths in range(round(10 * THING_S) + 2):
        near.see(local_map(1000 + 100 * tenths))
        if nearest(near, Pose2.identity()) > 0.12:
            return 0.1 * tenths
    return math.inf


@pytest.mark.parametrize(("shown", "lasts_s"), [(3, DOUBTFUL_S), (6, THING_S)])
def test_what_most_pictures_show_as_bare_floor_is_not_remembered_for_long(shown: int, lasts_s: float) -> None:
    assert remembered_for_s_after(NearThings(RADIUS_M), shown) == pytest.approx(lasts_s, abs=0.11)


def test_what_would_stand_in_the_own_bodys_middle_is_forgotten() -> None:
    near = NearThings(RADIUS_M)
    near.see(local_map(0, [region(box(0.3, 0.0, 0.02, 0.02))]))
    near.see(local_map(100, odom_from_body=Pose2(0.3 - 0.8 * RADIUS_M, 0.0, 0.0)))
    assert nearest(near, Pose2(0.3, 0.0, 0.0)) < 0.02
    near.see(local_map(200, odom_from_body=Pose2(0.3, 0.0, 0.0)))
    assert nearest(near, Pose2(0.3, 0.0, 0.0)) == math.inf
