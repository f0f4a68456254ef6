"""Robots in view are followed from frame to frame, each once; places that were tried in vain rest."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from agent.geometry import calibrated_projection
from agent.slam.robot_watch import LOST_FRAMES, MOST_A_FRAME, PAUSE_FRAMES, SURE, TRIES_PER_FRAME, RobotWatch
from agent.vision.floor_view import Picture
from agent.vision.robot_fit import RobotFit, RobotFitter
from protocol.geometry import Array
from tests.bench.frames import EXCERPT, open_case
from tests.unit.agent.moments import Moment, excerpt_moments

RADIUS_M, HEIGHT_M = 0.075, 0.30
FRAMES = 10
SAME_ROBOT_M = 0.5 * RADIUS_M
NO_BASES = np.zeros((0, 2))


class CountingFitter(RobotFitter):
    """Keeps where it was asked to search."""

    searched: list[tuple[float, float]]  # range to the base [m], bearing [rad]

    def search(self, grey: Picture, near_m: float, bearing_rad: float) -> Array | None:
        self.searched.append((near_m, bearing_rad))
        return super().search(grey, near_m, bearing_rad)


@pytest.fixture(scope="module")
def moments() -> list[Moment]:
    return excerpt_moments()


@pytest.fixture
def fitter() -> CountingFitter:
    fitter = CountingFitter(calibrated_projection(open_case(EXCERPT).subjects[0].calibration), RADIUS_M, HEIGHT_M)
    fitter.searched = []
    return fitter


@pytest.fixture
def watch(fitter: CountingFitter) -> RobotWatch:
    return RobotWatch(fitter, RADIUS_M, np.zeros(2))


def convinced(fit: RobotFit) -> float:
    return SURE


def doubtful(fit: RobotFit) -> float:
    return -0.5 * MOST_A_FRAME


def transparent(fit: RobotFit) -> float:
    return -math.inf


def nothing_seen(turn: int) -> Array:
    return NO_BASES


def look(watch: RobotWatch, moment: Moment, bases: Array) -> list[RobotFit]:
    return watch.look(moment.grey, moment.arena_from_body, bases, nothing_seen, convinced)


def begin(watch: RobotWatch, first: list[Moment]) -> None:
    """Have both robots found, and followed for a frame."""
    for moment in first[:2]:
        assert len(look(watch, moment, moment.bases())) == 2


def distances_m(found: list[RobotFit], moment: Moment) -> Array:
    """Return how far each robot found, (n, 1), is from each true one, (n, 2)."""
    centres = np.array([fit.centre_m for fit in found]).reshape(-1, 1, 2)
    return np.asarray(np.linalg.norm(centres - moment.robots_m, axis=-1))


@pytest.mark.parametrize("first", [0, 4, 15, 25, 35])
def test_both_robots_are_followed_with_no_more_help(first: int, moments: list[Moment], watch: RobotWatch) -> None:
    begin(watch, moments[first:])
    for moment in moments[first + 2 : first + FRAMES]:
        found = look(watch, moment, NO_BASES)
        assert len(found) == 2
        assert (distances_m(found, moment).min(axis=0) < SAME_ROBOT_M).all()


@pytest.mark.parametrize("first", [0, 4, 15, 25, 35])
def test_followed_robots_stay_where_they_truly_are(first: int, moments: list[Moment], watch: RobotWatch) -> None:
    begin(watch, moments[first:])
    errors_m = [distances_m(look(watch, moment, NO_BASES), moment).min(axis=0) for moment in moments[first + 2 : first + FRAMES]]
    assert np.max(errors_m) < 0.004


@pytest.mark.parametrize("first", [0, 15, 35])
def test_followed_robots_are_expected_where_they_will_be(first: int, moments: list[Moment], watch: RobotWatch) -> None:
    assert watch.expected_m(moments[first].arena_from_body).shape == (0, 2)
    begin(watch, moments[first:])
    moment = moments[first + 2]
    expected_m = watch.expected_m(moment.arena_from_body)
    assert np.linalg.norm(expected_m[:, None] - moment.robots_m, axis=2).min(axis=0).max() < 0.01


@pytest.mark.parametrize("first", [0, 15, 35])
def test_a_robot_that_is_lost_is_found_again_with_no_more_help(first: int, moments: list[Moment], watch: RobotWatch) -> None:
    begin(watch, moments[first:])
    missed, following = moments[first + 2 : first + 4]
    assert not look(watch, replace(missed, grey=np.zeros_like(missed.grey)), NO_BASES)
    expected_m = watch.expected_m(following.arena_from_body)
    assert np.linalg.norm(expected_m[:, None] - following.robots_m, axis=2).min(axis=0).max() < 0.025
    assert len(look(watch, following, NO_BASES)) == 2


@pytest.mark.parametrize("index", [0, 20, 40])
def test_robots_newly_found_are_where_they_truly_are(index: int, moments: list[Moment], watch: RobotWatch) -> None:
    one, other = moments[index].bases()[:1], moments[index].bases()[1:]
    for bases in (one, other, other):  # once a robot is in view, new places are tried in every other frame
        found = look(watch, moments[index], bases)
    assert len(found) == 2
    assert distances_m(found, moments[index]).min(axis=0).max() < 0.004


def test_nothing_is_found_twice_at_one_place(moments: list[Moment], watch: RobotWatch) -> None:
    for moment in moments[:FRAMES]:
        bases = np.repeat(moment.bases(), 3, axis=0) + np.tile([[0.0, 0.0], [0.01, 0.0], [0.0, 0.03]], (2, 1))
        found = look(watch, moment, bases)
        assert 1 <= len(found) <= 2
        assert (np.count_nonzero(distances_m(found, moment) < RADIUS_M, axis=0) <= 1).all()


def test_a_robot_that_is_followed_is_not_searched_for(moments: list[Moment], watch: RobotWatch, fitter: CountingFitter) -> None:
    begin(watch, moments)
    fitter.searched.clear()
    look(watch, moments[2], moments[2].bases())
    assert fitter.searched == []


def test_a_place_without_a_robot_rests_and_is_tried_again_later(moments: list[Moment], watch: RobotWatch, fitter: CountingFitter) -> None:
    bare = np.array([(0.5, 0.0)])
    tries: list[int] = []
    for _ in range(PAUSE_FRAMES + 2):
        assert look(watch, moments[0], bare) == []
        tries.append(len(fitter.searched))
    assert tries == [1] * PAUSE_FRAMES + [2, 2]
    assert fitter.searched[0] == pytest.approx((0.5 - RADIUS_M, 0.0))


def test_a_resting_place_is_one_of_the_floor_and_not_of_the_picture(
    moments: list[Moment], watch: RobotWatch, fitter: CountingFitter
) -> None:
    bare = np.array([(0.5, 0.0)])
    look(watch, moments[0], bare)
    look(watch, moments[8], bare)  # r1 has driven 20 cm since
    assert len(fitter.searched) == 2


def test_a_robot_is_still_found_beside_a_resting_place(moments: list[Moment], watch: RobotWatch) -> None:
    assert look(watch, moments[0], np.array([(0.5, 0.0)])) == []
    assert len(look(watch, moments[1], moments[1].bases())) == 2


def test_what_the_floors_border_suggests_does_not_hold_up_what_the_picture_does(moments: list[Moment], watch: RobotWatch) -> None:
    bare = np.array([(0.5, bearing) for bearing in (-0.9, -0.45, 0.0, 0.45, 0.9)])
    found = watch.look(moments[0].grey, moments[0].arena_from_body, bare, lambda turn: moments[0].bases(), convinced)
    assert len(found) == 2


def test_the_picture_is_scanned_all_round_also_while_a_robot_is_in_view_and_never_in_vain(moments: list[Moment], watch: RobotWatch) -> None:
    begin(watch, moments)
    turns: list[int] = []
    asked: list[int] = []

    def scan(turn: int) -> Array:
        turns.append(turn)
        return NO_BASES

    for moment in moments[2:10]:
        watch.look(moment.grey, moment.arena_from_body, NO_BASES, scan, convinced)
        asked.append(len(turns))
    assert np.diff(turns).tolist() == [1] * (len(turns) - 1)  # each turn another sector, and none left out
    assert sorted(set(np.diff(asked).tolist())) == [0, 2]  # none in the frames in which no new place is tried


def test_no_more_places_are_tried_in_a_frame_than_time_allows(moments: list[Moment], watch: RobotWatch, fitter: CountingFitter) -> None:
    bare = np.array([(0.5, bearing) for bearing in (-0.9, -0.45, 0.0, 0.45, 0.9)])
    look(watch, moments[0], bare)
    assert [bearing for _, bearing in fitter.searched] == pytest.approx([-0.9, -0.45][:TRIES_PER_FRAME])
    look(watch, moments[0], bare)
    assert [bearing for _, bearing in fitter.searched] == pytest.approx([-0.9, -0.45, 0.0, 0.45][: 2 * TRIES_PER_FRAME])


def test_nothing_is_a_robot_through_which_floor_shows(moments: list[Moment], watch: RobotWatch) -> None:
    found = watch.look(moments[0].grey, moments[0].arena_from_body, moments[0].bases(), nothing_seen, transparent)
    assert found == []
    begin(watch, moments[PAUSE_FRAMES:])
    moment = moments[PAUSE_FRAMES + 2]
    assert watch.look(moment.grey, moment.arena_from_body, NO_BASES, nothing_seen, transparent) == []


def test_what_does_not_look_like_a_robot_is_none_and_its_place_rests(
    moments: list[Moment], watch: RobotWatch, fitter: CountingFitter
) -> None:
    moment = moments[0]
    for _ in range(2):
        assert watch.look(moment.grey, moment.arena_from_body, moment.bases(), nothing_seen, doubtful) == []
    assert len(fitter.searched) == 2


def test_a_robot_that_looked_like_one_for_long_is_believed_for_a_while_and_then_given_up(moments: list[Moment], watch: RobotWatch) -> None:
    begin(watch, moments)
    moment = moments[2]
    counts = [len(watch.look(moment.grey, moment.arena_from_body, NO_BASES, nothing_seen, doubtful)) for _ in range(6)]
    assert counts == [2, 2, 2, 0, 0, 0]
    assert look(watch, moment, moment.bases()) == []  # its place rests


def test_robots_that_are_out_of_view_are_given_up(moments: list[Moment], watch: RobotWatch) -> None:
    begin(watch, moments)
    dark = Moment(np.zeros_like(moments[2].grey), moments[2].arena_from_body, moments[2].robots_m)
    for _ in range(LOST_FRAMES):
        assert look(watch, dark, NO_BASES) == []
    assert look(watch, moments[2], NO_BASES) == []
    assert len(look(watch, moments[3], moments[3].bases())) == 2
