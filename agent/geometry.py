"""The camera's geometry as the vision room wants it, from the robot's calibration."""

from __future__ import annotations

import numpy as np

from agent.rig import Calibration
from agent.vision.floor_projection import FloorProjection
from agent.vision.lens import Hemispherical, KannalaBrandt


def calibrated_projection(calibration: Calibration) -> FloorProjection:
    """Return the projection of the lens as calibrated."""
    lens = KannalaBrandt(
        *calibration.focal_px, *calibration.centre_px, *calibration.distortion, max_angle_rad=0.5 * calibration.field_of_view_rad
    )
    return FloorProjection(lens, calibration.body_from_camera)


def hemispherical_projection(calibration: Calibration) -> FloorProjection:
    """Return the projection of the paper's hemispherical lens (Eq. 6 and 7): F is the radius of the picture at 90 degrees off the axis."""
    sideways = calibrated_projection(calibration).lens.project(np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]]))
    radius_px = 0.5 * float(sideways[0, 0] - sideways[1, 0])
    return FloorProjection(Hemispherical(radius_px, *calibration.centre_px), calibration.body_from_camera)
