"""The code's own idea of the camera that `tests.synthetic` draws for, and what it makes of a picture."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from agent.vision.floor_patch import Field, FloorPatch
from agent.vision.floor_projection import FloorProjection
from agent.vision.floor_view import make_floor_view
from agent.vision.lens import KannalaBrandt
from tests.synthetic import BODY_HEIGHT_M, BODY_RADIUS_M, CAMERA_HEIGHT_M, CENTRE_PX, FLOOR, FOCAL_PX, HEIGHT_PX, WIDTH_PX, Rendering

SIZE_PX = (WIDTH_PX, HEIGHT_PX)
BODY_FROM_CAMERA = np.array([[0.0, -1.0, 0.0, 0.0], [-1.0, 0.0, 0.0, 0.0], [0.0, 0.0, -1.0, CAMERA_HEIGHT_M], [0.0, 0.0, 0.0, 1.0]])
PROJECTION = FloorProjection(KannalaBrandt(FOCAL_PX, FOCAL_PX, *CENTRE_PX), BODY_FROM_CAMERA)
VIEW = make_floor_view(PROJECTION, SIZE_PX, BODY_RADIUS_M, BODY_HEIGHT_M)
PATCH = FloorPatch(PROJECTION, VIEW)
FLOOR_MARGIN_M = 0.02


def patch_of(seen: Rendering) -> tuple[Field, NDArray[np.bool_]]:
    """Return the floor patch of a picture, and which of its cells truly show bare floor, (size, size) each."""
    not_floor = (seen.labels != FLOOR).astype(np.uint8)[VIEW.crop]
    grey = np.asarray(cv2.cvtColor(seen.picture, cv2.COLOR_BGR2GRAY), np.uint8)
    return PATCH.texture(PATCH.sample(grey)), PATCH.bare(not_floor, FLOOR_MARGIN_M)
