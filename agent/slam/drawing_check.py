"""Whether the camera sits where its calibration says: the rig as it was found while driving, beside the drawing."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from agent.rig import Calibration
from agent.slam.rig_parameters import CENTRE_SIGMA_RAD, HEIGHT_SHARE, TILT_SIGMA_RAD
from protocol.messages import RigValue

FAR_SIGMA = 4.0  # of how far rigs are from their drawings: no screw that was turned, but something bent or mistaken
KNOWN_SHARE = 0.5  # of that sigma: what is known less well than this was hardly seen


def wrong_drawing(rig: Sequence[RigValue], drawn: Calibration) -> str:
    """Return, in one line with the remedy, in what the rig as found is far from its drawing; empty where it is not."""
    axis = drawn.body_from_camera[:3, 2]
    centre_sigma_px = CENTRE_SIGMA_RAD * drawn.focal_px[0]
    expected = {
        "camera_height_m": ("height", drawn.camera_height_m, HEIGHT_SHARE * drawn.camera_height_m, 1e3, "mm"),
        "camera_tilt_forward_rad": ("tilt forward", float(axis[0]), TILT_SIGMA_RAD, float(np.degrees(1.0)), "degrees"),
        "camera_tilt_left_rad": ("tilt to the left", float(axis[1]), TILT_SIGMA_RAD, float(np.degrees(1.0)), "degrees"),
        "centre_u_px": ("lens centre across", drawn.centre_px[0], centre_sigma_px, 1.0, "px"),
        "centre_v_px": ("lens centre down", drawn.centre_px[1], centre_sigma_px, 1.0, "px"),
    }
    far = []
    for value in rig:
        if value.name not in expected or value.sigma is None:
            continue
        what, drawn_as, sigma, unit, name = expected[value.name]
        off = value.value - drawn_as
        if value.sigma < KNOWN_SHARE * sigma and abs(off) > FAR_SIGMA * sigma:
            far.append(f"{what} is off by {unit * off:+.1f} {name}")
    return f"camera: not where its calibration says: {', '.join(far)}: calibrate the rig again" if far else ""
