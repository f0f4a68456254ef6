"""A rig that is found far from its drawing is told; one that is a little off is every rig."""

from __future__ import annotations

from agent.slam.drawing_check import wrong_drawing
from protocol.messages import RigValue
from tests.unit.agent.eyes import CALIBRATION


def rig(height_m: float = 0.5, tilt_rad: float = 0.0, sigma: float = 1e-4) -> list[RigValue]:
    return [
        RigValue(name="camera_height_m", value=height_m, sigma=sigma),
        RigValue(name="camera_tilt_left_rad", value=tilt_rad, sigma=sigma),
        RigValue(name="wheel_base_m", value=9.0, sigma=sigma),
    ]


def test_rig_that_is_off_as_rigs_are_is_no_trouble() -> None:
    assert wrong_drawing(rig(height_m=0.508, tilt_rad=0.012), CALIBRATION) == ""


def test_camera_that_is_far_from_its_drawing_is_told_with_how_far() -> None:
    told = wrong_drawing(rig(height_m=0.525, tilt_rad=-0.05), CALIBRATION)
    where = "height is off by +25.0 mm, tilt to the left is off by -2.9 degrees"
    assert told == f"camera: not where its calibration says: {where}: calibrate the rig again"


def test_what_is_hardly_known_is_not_told() -> None:
    assert wrong_drawing(rig(height_m=0.6, sigma=0.01), CALIBRATION) == ""
