"""The code's own idea of the camera that `tests.synthetic` draws for, and what it makes of a picture."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from agent.rig import Calibration
from agent.vision.floor_patch import Field, FloorPatch
from agent.vision.floor_projection import FloorProjection
from agent.vision.floor_view import make_floor_view
from agent.vision.lens import KannalaBrandt
from agent.vision.shutter import RollingShutter
from agent.wheel_history import WheelState
from tests.synthetic import (
    BODY_HEIGHT_M,
    BODY_RADIUS_M,
    CAMERA_HEIGHT_M,
    CENTRE_PX,
    FLOOR,
    FOCAL_PX,
    HALF_FIELD_RAD,
    HEIGHT_PX,
    WIDTH_PX,
    Rendering,
)

SIZE_PX = (WIDTH_PX, HEIGHT_PX)
BODY_FROM_CAMERA = np.array([[0.0, -1.0, 0.0, 0.0], [-1.0, 0.0, 0.0, 0.0], [0.0, 0.0, -1.0, CAMERA_HEIGHT_M], [0.0, 0.0, 0.0, 1.0]])
CALIBRATION = Calibration(
    WIDTH_PX, HEIGHT_PX, (FOCAL_PX, FOCAL_PX), CENTRE_PX, (0.0, 0.0, 0.0, 0.0), 2.0 * float(HALF_FIELD_RAD), BODY_FROM_CAMERA
)
DECK_RADIUS_M = BODY_RADIUS_M - 0.004  # within the rim
PROJECTION = FloorProjection(KannalaBrandt(FOCAL_PX, FOCAL_PX, *CENTRE_PX), BODY_FROM_CAMERA)
VIEW = make_floor_view(PROJECTION, SIZE_PX, BODY_RADIUS_M, BODY_HEIGHT_M)
PATCH = FloorPatch(PROJECTION, VIEW)
SHUTTER = RollingShutter(PATCH, PROJECTION, HEIGHT_PX, readout_s=0.0)
FLOOR_MARGIN_M = 0.02


def turned(angles_rad: ArrayLike) -> WheelState:
    """Return wheels that have turned so far, (2,) left and right, whatever their speed."""
    return WheelState(np.asarray(angles_rad, np.float64), np.zeros(2))


def patch_of(seen: Rendering) -> tuple[Field, NDArray[np.bool_]]:
    """Return the floor patch of a picture, and which of its cells truly show bare floor, (size, size) each."""
    not_floor = (seen.labels != FLOOR).astype(np.uint8)[VIEW.crop]
    grey = np.asarray(cv2.cvtColor(seen.picture, cv2.COLOR_BGR2GRAY), np.uint8)
    return PATCH.texture(PATCH.sample(grey)), PATCH.bare(not_floor, FLOOR_MARGIN_M)
