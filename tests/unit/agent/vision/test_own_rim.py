"""The own rim is found to a fraction of a pixel, however the camera is really mounted."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from agent.slam.rig_parameters import CENTRE, HEIGHT, PARAMETERS, TILT
from agent.slam.rig_sensitivity import circle_px, rim_sensitivity
from agent.vision.own_rim import OwnRim, RimShift
from protocol.geometry import Array, Pose2
from tests.synthetic import BODY_HEIGHT_M, BODY_RADIUS_M, render
from tests.unit.agent.eyes import CALIBRATION, DECK_RADIUS_M

NO_CHANGE = np.zeros(PARAMETERS)


def change(height_m: float = 0.0, tilt_rad: tuple[float, float] = (0.0, 0.0), centre_px: tuple[float, float] = (0.0, 0.0)) -> Array:
    wrong = NO_CHANGE.copy()
    wrong[HEIGHT], wrong[TILT], wrong[CENTRE] = height_m, tilt_rad, centre_px
    return wrong


def found(wrong: Array, floor: str = "paint") -> RimShift | None:
    """Return the shift of the rim beside where a rig that is wrong by so much expects it."""
    rim = OwnRim(*(circle_px(CALIBRATION, wrong, radius_m, BODY_HEIGHT_M) for radius_m in (DECK_RADIUS_M, BODY_RADIUS_M)))
    for number in range(2):
        picture = render(floor, Pose2(0.1 * number, 0.0, 0.0), seed=number).picture
        rim.add(np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY), np.uint8))
    return rim.shift()


@pytest.mark.parametrize("floor", ["paint", "grid", "wood"])
@pytest.mark.parametrize(
    "wrong", [change(), change(height_m=0.007), change(tilt_rad=(0.008, -0.004)), change(-0.006, (0.004, 0.006), (1.5, -1.0))]
)
def test_the_rim_is_found_where_it_is(wrong: Array, floor: str) -> None:
    shift = found(wrong, floor)
    assert shift is not None
    expected = rim_sensitivity(CALIBRATION, DECK_RADIUS_M, BODY_HEIGHT_M) @ -wrong[:8]
    assert np.array([shift.radius_px, *shift.centre_px]) == pytest.approx(expected, abs=0.25)


def test_where_there_is_no_rim_none_is_found() -> None:
    rim = OwnRim(*(circle_px(CALIBRATION, NO_CHANGE, radius_m, BODY_HEIGHT_M) for radius_m in (DECK_RADIUS_M, BODY_RADIUS_M)))
    rim.add(np.zeros((CALIBRATION.height_px, CALIBRATION.width_px), np.uint8))
    assert rim.shift() is None
