"""What parallax tells of corners followed over many frames."""

import numpy as np
import pytest

from agent.slam.feature_tracks import begin, heights, join, no_tracks, observe, place_sigmas, relabel
from protocol.geometry import Pose2
from tests.unit.agent.floor_worlds import HEIGHT_M, SIGMA_M, WAY_M, appearances, watched

FLOOR_POINT, LOW_POINT, HIGH_POINT = (0.8, 0.1, 0.0), (0.8, 0.1, 0.1), (1.0, -0.3, 0.25)


def test_a_point_on_the_floor_has_no_slope() -> None:
    assert watched([FLOOR_POINT]).slopes()[0] == pytest.approx([0.0], abs=1e-12)


def test_the_slope_of_a_standing_point_is_that_of_its_height() -> None:
    # 1 - 0.5 / 0.4 and 1 - 0.5 / 0.25.
    assert watched([LOW_POINT, HIGH_POINT]).slopes()[0] == pytest.approx([-0.25, -1.0])


def test_heights_undo_slopes() -> None:
    assert heights(np.array([0.0, -0.25, -1.0]), HEIGHT_M) == pytest.approx([0.0, 0.1, 0.25])


def test_what_moves_along_has_a_slope_of_one_and_is_told_as_moving() -> None:
    tracks = watched([FLOOR_POINT, LOW_POINT], along=True)
    assert tracks.slopes()[0] == pytest.approx([1.0, 1.0])
    assert tracks.moving().all()
    assert not tracks.settled(0.05).any()


def test_standing_points_do_not_move_and_settle() -> None:
    tracks = watched([FLOOR_POINT, LOW_POINT, HIGH_POINT])
    assert not tracks.moving().any()
    assert tracks.settled(0.05).all()


def test_what_leaves_its_straight_line_moves() -> None:
    tracks = watched([FLOOR_POINT, FLOOR_POINT])
    for step in range(1, 6):
        aside = appearances([FLOOR_POINT, (0.8, 0.1 + 0.01 * step, 0.0)])
        tracks = observe(tracks, tracks.pixels, aside, np.full(2, SIGMA_M), np.zeros(2))
    assert tracks.misfit()[0] == pytest.approx(0.0, abs=1e-9)
    assert tracks.moving().tolist() == [False, True]


def test_three_observations_are_too_few_to_tell() -> None:
    assert not watched([FLOOR_POINT], way_m=WAY_M[::5], along=True).moving().any()
    assert watched([FLOOR_POINT], way_m=WAY_M[:8:2], along=True).moving().all()


def test_a_camera_that_stands_tells_no_slope() -> None:
    slope, sigma = watched([LOW_POINT], way_m=np.zeros((6, 2))).slopes()
    assert slope.tolist() == [0.0]
    assert sigma.tolist() == [np.inf]


def test_a_slope_is_known_the_better_the_farther_the_camera_drove() -> None:
    near, far = (watched([LOW_POINT], way_m=way).slopes()[1][0] for way in (0.5 * WAY_M, WAY_M))
    assert far == pytest.approx(0.5 * near)


def test_places_are_predicted_along_the_line() -> None:
    ahead = np.array([0.05, 0.02])
    points = [FLOOR_POINT, LOW_POINT, HIGH_POINT]
    assert watched(points).predicted_places(ahead) == pytest.approx(appearances(points, ahead))


def test_a_new_corner_is_predicted_where_it_was_seen() -> None:
    place = np.array([[0.9, 0.2]])
    new = begin(np.zeros((1, 2)), np.ones(1, np.int32), place, np.array([SIGMA_M]), np.zeros(2))
    assert new.predicted_places(np.array([0.3, 0.0])) == pytest.approx(place)


def test_the_oldest_observations_are_forgotten() -> None:
    tracks = watched([LOW_POINT])
    for _ in range(400):
        tracks = observe(tracks, tracks.pixels, appearances([LOW_POINT]), np.full(1, SIGMA_M), np.zeros(2))
    assert tracks.weight[0] == pytest.approx(SIGMA_M**-2 / 0.03, rel=1e-3)  # a geometric series of 0.97
    assert tracks.eye_power[0] < 1.0  # the way is long ago
    assert tracks.eye_m[0] == pytest.approx([0.0, 0.0], abs=1e-5)


def test_selecting_joining_and_relabelling_keep_corners_whole() -> None:
    standing, along = watched([FLOOR_POINT, HIGH_POINT], label=3), watched([LOW_POINT], label=7, along=True)
    both = join(join(no_tracks(), standing), along)
    assert both.labels.tolist() == [3, 3, 7]
    last = both.select(np.array([2, 1]))
    assert last.labels.tolist() == [7, 3]
    assert last.slopes()[0] == pytest.approx([1.0, -1.0])
    assert last.pixels == pytest.approx(np.stack([along.pixels[0], standing.pixels[1]]))
    named = relabel(both, np.array([1, 2, 4], np.int32))
    assert named.labels.tolist() == [1, 2, 4]
    assert named.slopes()[0] == pytest.approx(both.slopes()[0])
    assert len(both.select(both.moving())) == 1


def test_a_pixel_covers_more_floor_farther_out() -> None:
    # At the foot of the axis one pixel is 0.5 m * 0.005 rad; at 45 degrees twice that, whichever way the robot looks.
    places = np.array([[1.0, 2.0], [1.0, 2.5]])
    under, at_45_degrees = place_sigmas(places, Pose2(1.0, 2.0, 0.7), HEIGHT_M, 0.005)
    assert under == pytest.approx(0.35 * 0.0025)
    assert at_45_degrees == pytest.approx(2.0 * under)
