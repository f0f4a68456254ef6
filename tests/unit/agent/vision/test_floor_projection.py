"""From pixels to the floor and back, at any tilt, with nothing at or above the horizon."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from agent.vision.floor_projection import FloorProjection
from agent.vision.lens import Hemispherical, KannalaBrandt
from protocol.errors import GeometryError
from protocol.geometry import Array

LENS = KannalaBrandt(300.0, 300.0, 640.0, 480.0)
LOOKING_DOWN = np.array([[0.0, -1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])  # body from camera


def camera_pose(pitch_rad: float = 0.0, roll_rad: float = 0.0, height_m: float = 0.5) -> Array:
    """Return the pose of a camera that looks down, its axis swung forwards by `pitch_rad` and then to the left by `roll_rad`."""
    c, s = math.cos(-pitch_rad), math.sin(-pitch_rad)
    about_y = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    c, s = math.cos(roll_rad), math.sin(roll_rad)
    about_x = np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])
    pose = np.eye(4)
    pose[:3, :3] = about_x @ about_y @ LOOKING_DOWN
    pose[:3, 3] = (0.01, -0.02, height_m)
    return pose


def pixel_at(theta_rad: float, towards_u: float, towards_v: float) -> list[float]:
    return [640.0 + 300.0 * theta_rad * towards_u, 480.0 + 300.0 * theta_rad * towards_v]


def test_image_up_is_forward_and_image_left_is_left() -> None:
    floor = FloorProjection(LENS, camera_pose()).floor_from_pixels(
        [pixel_at(math.pi / 4, 0, -1), pixel_at(math.pi / 4, -1, 0), [640.0, 480.0]]
    )
    assert floor == pytest.approx(np.array([[0.51, -0.02], [0.01, 0.48], [0.01, -0.02]]))


def test_a_camera_tilted_by_30_degrees_looks_half_a_metre_times_tan_30_ahead() -> None:
    projection = FloorProjection(LENS, camera_pose(pitch_rad=math.radians(30.0)))
    assert projection.floor_from_pixels([[640.0, 480.0]]) == pytest.approx(np.array([[0.01 + 0.5 * math.tan(math.radians(30.0)), -0.02]]))


@pytest.mark.parametrize("degrees", [90.0, 90.5, 92.4, 93.0])
def test_a_ray_at_or_above_the_horizon_has_no_floor_point(degrees: float) -> None:
    projection = FloorProjection(LENS, camera_pose())
    around = [pixel_at(math.radians(degrees), math.cos(phi), math.sin(phi)) for phi in np.linspace(0.0, 6.0, 50)]
    assert np.isnan(projection.floor_from_pixels(around)).all()


def test_a_ray_just_below_the_horizon_has_one() -> None:
    floor = FloorProjection(LENS, camera_pose()).floor_from_pixels([pixel_at(math.radians(89.9), 0, -1)])
    assert floor[0, 0] == pytest.approx(0.01 + 0.5 * math.tan(math.radians(89.9)))


def test_the_horizon_follows_the_tilt() -> None:
    projection = FloorProjection(LENS, camera_pose(pitch_rad=math.radians(30.0)))
    ahead = [pixel_at(math.radians(degrees), 0, -1) for degrees in (59.9, 60.0, 60.1)]
    assert np.isfinite(projection.floor_from_pixels(ahead)).all(axis=1).tolist() == [True, False, False]
    assert np.isfinite(projection.floor_from_pixels([pixel_at(math.radians(92.0), 0, 1)])).all()


def test_the_hemispherical_lens_corrects_to_the_floor_by_equation_6() -> None:
    projection = FloorProjection(Hemispherical(500.0, 640.0, 480.0), camera_pose())
    assert projection.floor_from_pixels([[640.0, 180.0]]) == pytest.approx(np.array([[0.01 + 0.5 * 375.0 / 500.0, -0.02]]))
    assert np.isnan(projection.floor_from_pixels([[640.0, -20.0]])).all()


def test_a_point_in_the_air_is_seen_where_its_ray_meets_the_floor() -> None:
    projection = FloorProjection(LENS, camera_pose(height_m=0.5))
    pixels = projection.pixels_from_points([[0.11, -0.02, 0.3]])  # 0.1 m ahead and 0.2 m below: meets the floor 0.25 m ahead
    assert projection.floor_from_pixels(pixels) == pytest.approx(np.array([[0.26, -0.02]]))


def test_a_point_above_the_view_has_no_pixel() -> None:
    assert np.isnan(FloorProjection(LENS, camera_pose()).pixels_from_points([[0.01, -0.02, 0.8], [1.0, 0.0, 0.7]])).all()


def test_a_ray_in_the_air_ends_after_the_reach() -> None:
    projection = FloorProjection(LENS, camera_pose())
    points = projection.points_from_pixels([pixel_at(math.radians(91.0), 0, -1), pixel_at(math.pi / 4, 0, -1), [0.0, 0.0]], reach_m=3.0)
    assert points[0] == pytest.approx([0.01 + 3.0 * math.sin(math.radians(91.0)), -0.02, 0.5 + 3.0 * math.sin(math.radians(1.0))])
    assert points[1] == pytest.approx([0.51, -0.02, 0.0])
    assert np.isnan(points[2]).all()


@given(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0), st.floats(-0.3, 0.3), st.floats(-0.3, 0.3))
def test_floor_points_return_through_the_picture_at_any_tilt(x_m: float, y_m: float, pitch_rad: float, roll_rad: float) -> None:
    projection = FloorProjection(LENS, camera_pose(pitch_rad, roll_rad))
    pixels = projection.pixels_from_floor([[x_m, y_m]])
    seen = bool(np.isfinite(pixels).all())
    assert seen or math.hypot(x_m, y_m) > 0.5
    assert not seen or projection.floor_from_pixels(pixels) == pytest.approx(np.array([[x_m, y_m]]), abs=1e-6)


@pytest.mark.parametrize(
    ("pose", "reason"),
    [
        (np.full((4, 4), np.nan), "finite"),
        (np.eye(3), "4 x 4"),
        (np.diag([1.0, 2.0, 1.0, 1.0]), "rotation"),
        (np.diag([1.0, -1.0, 1.0, 1.0]), "rotation"),
        (camera_pose(height_m=0.0), "above the floor"),
    ],
)
def test_a_matrix_that_is_no_pose_above_the_floor_is_refused(pose: Array, reason: str) -> None:
    with pytest.raises(GeometryError, match=reason):
        FloorProjection(LENS, pose)
