"""The camera's geometry from the robot's calibration."""

import math

import numpy as np
import pytest

from agent.geometry import calibrated_projection, hemispherical_projection
from agent.rig import Calibration
from agent.vision.lens import Hemispherical
from protocol.errors import GeometryError
from tests.unit.agent.floor_worlds import POSE


def calibration(field_of_view_deg: float = 185.0, k1: float = 0.0) -> Calibration:
    return Calibration(640, 480, (200.0, 210.0), (321.0, 242.0), (k1, 0.0, 0.0, 0.0), math.radians(field_of_view_deg), POSE)


def test_the_calibrated_projection_is_the_lens_as_calibrated() -> None:
    # A floor point 0.5 m ahead of a camera 0.5 m high is 45 degrees off the axis, and up in the picture.
    theta = math.pi / 4.0
    pixel = calibrated_projection(calibration(k1=0.02)).pixels_from_floor(np.array([[0.5, 0.0]]))
    assert pixel == pytest.approx(np.array([[321.0, 242.0 - 210.0 * (theta + 0.02 * theta**3)]]))


def test_the_field_of_view_ends_the_lens() -> None:
    at_60_degrees = np.array([[0.5 * math.tan(math.radians(60.0)), 0.0]])
    assert np.isfinite(calibrated_projection(calibration(122.0)).pixels_from_floor(at_60_degrees)).all()
    assert np.isnan(calibrated_projection(calibration(118.0)).pixels_from_floor(at_60_degrees)).all()


@pytest.mark.parametrize("k1", [0.0, 0.03, -0.05])
def test_the_hemispherical_radius_is_that_of_the_picture_at_90_degrees(k1: float) -> None:
    lens = hemispherical_projection(calibration(k1=k1)).lens
    quarter = math.pi / 2.0
    assert isinstance(lens, Hemispherical)
    assert pytest.approx(200.0 * (quarter + k1 * quarter**3)) == lens.F
    assert (lens.cx, lens.cy) == (321.0, 242.0)


def test_both_lenses_look_from_the_same_place() -> None:
    given = calibration()
    assert (hemispherical_projection(given).body_from_camera == calibrated_projection(given).body_from_camera).all()


def test_a_lens_that_does_not_see_sideways_has_no_hemispherical_model() -> None:
    with pytest.raises(GeometryError, match="hemispherical"):
        hemispherical_projection(calibration(160.0))
