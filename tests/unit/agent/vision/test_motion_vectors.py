"""Correction of start and end points, and the prediction of ends from the wheels."""

import math

import numpy as np
import pytest

from agent.vision.floor_projection import FloorProjection
from agent.vision.lens import KannalaBrandt
from agent.vision.motion_vectors import correct_vectors, predict_ends
from protocol.geometry import Pose2

POSE = np.array([[0.0, -1.0, 0.0, 0.0], [-1.0, 0.0, 0.0, 0.0], [0.0, 0.0, -1.0, 0.5], [0.0, 0.0, 0.0, 1.0]])
PROJECTION = FloorProjection(KannalaBrandt(300.0, 300.0, 640.0, 480.0), POSE)
FLOOR = np.array([[0.5, 0.0], [0.0, 0.5], [-0.4, -0.3]])
ONWARD = Pose2(0.05, 0.0, math.radians(10.0))  # previous from body


def test_static_points_move_against_the_robot_by_what_it_moved() -> None:
    starts = PROJECTION.pixels_from_floor(FLOOR)
    ends = PROJECTION.pixels_from_floor(FLOOR - [0.05, 0.0])
    vectors = correct_vectors(starts, ends, np.array([1, 1, 2], np.int32), PROJECTION)
    assert len(vectors) == 3
    assert vectors.starts_m == pytest.approx(FLOOR)
    assert vectors.vectors_m == pytest.approx(np.tile([-0.05, 0.0], (3, 1)))
    assert vectors.vectors_px == pytest.approx(ends - starts)


def test_a_point_above_the_horizon_has_no_corrected_vector() -> None:
    above = np.array([[640.0, 480.0 - 300.0 * math.radians(91.0)]])
    vectors = correct_vectors(above, above, np.array([1], np.int32), PROJECTION)
    assert np.isnan(vectors.vectors_m).all()


def test_selection_keeps_rows_together() -> None:
    pixels = PROJECTION.pixels_from_floor(FLOOR)
    vectors = correct_vectors(pixels, pixels, np.array([1, 2, 3], np.int32), PROJECTION).select(np.array([False, True, True]))
    assert vectors.labels.tolist() == [2, 3]
    assert vectors.starts_m == pytest.approx(FLOOR[1:])


def test_floor_points_are_predicted_where_the_robot_will_see_them() -> None:
    predicted = predict_ends(PROJECTION.pixels_from_floor(FLOOR), ONWARD, PROJECTION, reach_m=3.0)
    assert PROJECTION.floor_from_pixels(predicted) == pytest.approx(ONWARD.inverse().apply(FLOOR))


def test_a_far_thing_above_the_horizon_turns_with_the_robot() -> None:
    ahead = np.array([[640.0, 480.0 - 300.0 * math.radians(91.0)]])
    turned = predict_ends(ahead, Pose2(0.0, 0.0, math.radians(10.0)), PROJECTION, reach_m=3.0) - [640.0, 480.0]
    assert np.hypot(*turned.T) == pytest.approx(300.0 * math.radians(91.0))
    assert math.degrees(math.atan2(turned[0, 0], -turned[0, 1])) == pytest.approx(10.0)  # the robot turned left, so it went right


def test_a_pixel_outside_the_image_circle_has_no_prediction() -> None:
    assert np.isnan(predict_ends(np.array([[0.0, 0.0]]), ONWARD, PROJECTION, reach_m=3.0)).all()
