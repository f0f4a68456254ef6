"""Own translation, robots and objects by the paper's corrected vectors."""

import math

import numpy as np
import pytest

from agent.slam.paper_objects import describe, static_translation, tell_robots
from agent.vision.motion_vectors import MotionVectors
from protocol.geometry import Array, Pose2
from tests.unit.agent.floor_worlds import PROJECTION

MOTION = Pose2(0.05, 0.01, math.radians(8.0))
STARTS = np.array([[0.6, 0.1], [0.7, 0.3], [0.5, 0.4], [-0.4, 0.5], [-0.6, -0.2]])


def vectors_of(starts_m: Array, ends_m: Array, labels: list[int]) -> MotionVectors:
    to_px = PROJECTION.pixels_from_floor
    return MotionVectors(to_px(starts_m), to_px(ends_m), starts_m, ends_m, np.array(labels, np.int32))


STATIC_ENDS = MOTION.inverse().apply(STARTS)
ALONG_ENDS = STARTS @ MOTION.rotation()  # of what drives beside us: it stays where it is, but for our own turn


def test_the_translation_of_a_known_motion_is_exact_though_the_wheels_were_wrong() -> None:
    vectors = vectors_of(STARTS, STATIC_ENDS, [1, 1, 1, 2, 2])
    slipping = Pose2(0.07, 0.0, MOTION.theta_rad)
    assert static_translation(vectors, slipping) == pytest.approx([0.05, 0.01])


def test_the_translation_is_a_median() -> None:
    ends = STATIC_ENDS.copy()
    ends[0] += [0.2, -0.3]
    assert static_translation(vectors_of(STARTS, ends, [1, 1, 1, 2, 2]), MOTION) == pytest.approx([0.05, 0.01])


def test_robots_and_floor_have_no_say_in_the_translation() -> None:
    ends = np.concatenate([STATIC_ENDS, ALONG_ENDS, STARTS])
    vectors = vectors_of(np.tile(STARTS, (3, 1)), ends, [1] * 5 + [7] * 5 + [0] * 5)
    assert static_translation(vectors, MOTION) == pytest.approx([0.05, 0.01])


def test_where_nothing_is_static_the_wheels_are_believed() -> None:
    assert static_translation(vectors_of(STARTS, ALONG_ENDS, [7] * 5), MOTION) == pytest.approx([0.05, 0.01])
    assert static_translation(vectors_of(STARTS, STATIC_ENDS, [0] * 5), MOTION) == pytest.approx([0.05, 0.01])


def test_what_moves_along_is_a_robot_and_what_comes_towards_us_is_not() -> None:
    vectors = vectors_of(np.tile(STARTS, (3, 1)), np.concatenate([STATIC_ENDS, ALONG_ENDS, STARTS]), [1] * 5 + [7] * 5 + [0] * 5)
    assert tell_robots(vectors, MOTION) == {7}


def test_a_robot_that_stands_tells_nobody() -> None:
    assert tell_robots(vectors_of(STARTS, STARTS, [7] * 5), Pose2(0.001, 0.0, 0.0)) == set()


SQUARE = np.array([[0.6, 0.0], [0.8, 0.0], [0.8, 0.2], [0.6, 0.2]])


def test_an_object_is_the_hull_of_its_corners_with_its_centre() -> None:
    corners = PROJECTION.pixels_from_floor(np.concatenate([SQUARE, [[0.7, 0.1]], SQUARE - [1.5, 0.0]]))
    still, moving = describe(corners, np.array([3] * 5 + [4] * 4, np.int32), {4}, PROJECTION, reach_m=2.0)
    assert (still.label, still.motion, moving.label, moving.motion) == (3, "static", 4, "moving")
    assert np.sort(still.outline_m, axis=0) == pytest.approx(np.sort(SQUARE, axis=0))
    assert still.centre_m == pytest.approx([0.7, 0.1])
    assert moving.centre_m == pytest.approx([-0.8, 0.1])


def test_corners_out_of_reach_on_the_floor_or_too_few_make_no_object() -> None:
    far = PROJECTION.pixels_from_floor(SQUARE + np.array([1.5, 0.0]))
    above = np.array([[319.5, 319.5 - 200.0 * math.radians(91.0)]])
    corners = np.concatenate([far, above, PROJECTION.pixels_from_floor(np.concatenate([SQUARE, SQUARE[:2]]))])
    labels = np.array([1] * 5 + [0] * 4 + [2] * 2, np.int32)
    assert describe(corners, labels, set(), PROJECTION, reach_m=2.0) == []
    assert [thing.label for thing in describe(corners, labels, set(), PROJECTION, reach_m=4.0)] == [1]
