"""The rig as it was found to be, for people: lengths and angles with their uncertainty."""

from __future__ import annotations

import numpy as np

from agent.rig import Calibration
from agent.slam.odometry import WheelGeometry
from agent.slam.rig_estimator import RigEstimate
from agent.slam.rig_parameters import BASE, CENTRE, FOCAL, HEIGHT, LAG, LEFT, OFFSET, RIGHT, changed_calibration, changed_wheels
from protocol.messages import RigValue


def rig_values(drawn: Calibration, wheels: WheelGeometry, found: RigEstimate, *, has_scale: bool) -> tuple[RigValue, ...]:
    """Return what a rig that differs from its drawing measures; without a scale, lengths are multiples of the camera's height."""
    sigma = np.sqrt(np.diag(found.covariance))
    camera, turning = changed_calibration(drawn, found.change), changed_wheels(wheels, found.change)
    height_m = camera.camera_height_m
    unit, length = ("m", 1.0) if has_scale else ("camera_heights", height_m)
    axis = camera.body_from_camera[:3, 2]  # of the lens; straight down is (0, 0, -1)
    tilt_sigma = float(np.hypot(*sigma[1:3])) / np.sqrt(2.0)
    rows = [
        ("camera_height_m", height_m, sigma[HEIGHT]) if has_scale else ("camera_height_m", height_m, np.inf),
        ("camera_tilt_rad", float(np.hypot(axis[0], axis[1])), tilt_sigma),
        ("camera_tilt_forward_rad", float(axis[0]), sigma[2]),
        ("camera_tilt_left_rad", float(axis[1]), sigma[1]),
        ("centre_u_px", camera.centre_px[0], sigma[CENTRE][0]),
        ("centre_v_px", camera.centre_px[1], sigma[CENTRE][1]),
        ("focal_px", camera.focal_px[0], sigma[FOCAL] * camera.focal_px[0]),
        (f"camera_offset_x_{unit}", float(camera.body_from_camera[0, 3]) / length, sigma[OFFSET][0] / length),
        (f"camera_offset_y_{unit}", float(camera.body_from_camera[1, 3]) / length, sigma[OFFSET][1] / length),
        (f"wheel_radius_left_{unit}", turning.radius_m * turning.scale[0] / length, sigma[LEFT] * turning.radius_m / length),
        (f"wheel_radius_right_{unit}", turning.radius_m * turning.scale[1] / length, sigma[RIGHT] * turning.radius_m / length),
        (f"wheel_base_{unit}", turning.base_m / length, sigma[BASE] * turning.base_m / length),
        ("wheel_lag_s", float(found.change[LAG]), sigma[LAG]),
    ]
    return tuple(RigValue(name=name, value=float(value), sigma=float(off) if np.isfinite(off) else None) for name, value, off in rows)
