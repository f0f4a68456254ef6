"""The numbers by which a robot as built differs from its drawing and calibration, as one vector, and how to apply them."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np

from agent.geometry import calibrated_projection
from agent.rig import Calibration
from agent.slam.odometry import WheelGeometry
from agent.vision.floor_projection import FloorProjection
from protocol.geometry import Array

# height [m], tilt about the body's x and y axis [rad], lens centre along u and v [px], focal length [of itself], offset [m]; ...
HEIGHT, TILT, CENTRE, FOCAL, OFFSET = 0, slice(1, 3), slice(3, 5), 5, slice(6, 8)
LEFT, RIGHT, BASE, LAG = 8, 9, 10, 11  # ... radii of the wheels and base [of themselves], stamps later than readings [s]
CAMERA, WHEELS = slice(0, 8), slice(8, 12)
PARAMETERS = 12

HEIGHT_SHARE = 0.01  # one sigma of what is not known of a rig, of its height
TILT_SIGMA_RAD, CENTRE_SIGMA_RAD, FOCAL_SIGMA, OFFSET_SIGMA_M = 0.006, 0.008, 0.003, 0.004
RADIUS_SIGMA, BASE_SIGMA, LAG_SIGMA_S = 0.02, 0.03, 0.03


def prior_sigma(calibration: Calibration) -> Array:
    """Return how far rigs are from their drawings, one sigma of each parameter, shape (PARAMETERS,)."""
    centre_px = CENTRE_SIGMA_RAD * calibration.focal_px[0]
    camera = [HEIGHT_SHARE * calibration.camera_height_m, TILT_SIGMA_RAD, TILT_SIGMA_RAD, centre_px, centre_px, FOCAL_SIGMA]
    return np.array([*camera, OFFSET_SIGMA_M, OFFSET_SIGMA_M, RADIUS_SIGMA, RADIUS_SIGMA, BASE_SIGMA, LAG_SIGMA_S])


def changed_calibration(calibration: Calibration, change: Array) -> Calibration:
    """Return a calibration with a change, (PARAMETERS,) or its CAMERA part, applied."""
    body_from_camera = calibration.body_from_camera.copy()
    body_from_camera[:3, :3] = cv2.Rodrigues(np.array([*change[TILT], 0.0]))[0] @ body_from_camera[:3, :3]
    body_from_camera[:3, 3] += (*change[OFFSET], change[HEIGHT])
    fx, fy = calibration.focal_px
    cx, cy = calibration.centre_px
    stretch = float(np.exp(change[FOCAL]))
    return replace(
        calibration,
        focal_px=(fx * stretch, fy * stretch),
        centre_px=(cx + float(change[CENTRE][0]), cy + float(change[CENTRE][1])),
        body_from_camera=body_from_camera,
    )


def changed_projection(calibration: Calibration, change: Array) -> FloorProjection:
    """Return the projection of a calibration with a change applied."""
    return calibrated_projection(changed_calibration(calibration, change))


def changed_wheels(wheels: WheelGeometry, change: Array) -> WheelGeometry:
    """Return the wheels with a change, (PARAMETERS,), applied."""
    left, right, base = np.exp(change[[LEFT, RIGHT, BASE]]).tolist()
    return WheelGeometry(wheels.radius_m, wheels.base_m * base, (wheels.scale[0] * left, wheels.scale[1] * right))
