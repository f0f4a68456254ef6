"""The verdict on a calibration in plain words: what it is worth, what is wrong, and what to do about it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from agent.lens_calibration.accuracy import direction_errors_rad, empty_sectors
from agent.lens_calibration.camera import FRAME
from agent.lens_calibration.field import Field
from agent.lens_calibration.fit import LensFit

Grade = Literal["good", "usable", "refused"]

REFUSED_RMS_SHARE, DOUBTFUL_RMS_SHARE = 1.5e-3, 8e-4  # of the picture's width: 1 px and 0.5 px of 640
REFUSED_FOCAL_SHARE = 0.01
REFUSED_CENTRE_SHARE = 5e-3  # of the picture's width
REFUSED_ERROR_M, DOUBTFUL_ERROR_M = 0.010, 0.002  # of a point 1 m away
REFUSED_REACH, DOUBTFUL_REACH = 0.4, 0.75  # of the field's radius
ENOUGH_PICTURES = 10


@dataclass(frozen=True)
class Verdict:
    """What a calibration is worth."""

    grade: Grade
    rms_px: float
    pictures: int
    reach: float  # share of the field's radius to which corners were seen
    seen_to_deg: float  # from the axis
    error_at_1m_m: float  # standard deviation of a point 1 m away, where it is worst among what was seen
    reasons: tuple[str, ...]  # why it is not good
    advice: tuple[str, ...]


def judge(fit: LensFit, field: Field) -> Verdict:
    """Return the verdict on a lens that was found."""
    error_m = float(direction_errors_rad(fit).max())
    reach = min(_seen_radius_px(fit) / field.radius_px, 1.0)
    fatal = _fatal(fit, error_m, reach)
    doubts, advice = _doubts(fit, field, error_m, reach)
    grade: Grade = "refused" if fatal else "usable" if doubts else "good"
    seen_deg = float(np.degrees(fit.seen_to_rad))
    return Verdict(grade, fit.best.rms_px, len(fit.used), reach, seen_deg, error_m, (*fatal, *doubts), tuple(advice))


def _fatal(fit: LensFit, error_m: float, reach: float) -> list[str]:
    """Return why the data cannot carry a calibration."""
    width = fit.size_px[0]
    sigma = np.sqrt(np.diag(fit.best.covariance))
    focal, centre = float((sigma[:2] / fit.camera.values[:2]).max()), float(sigma[2:FRAME].max())
    found = []
    if fit.best.rms_px > REFUSED_RMS_SHARE * width:
        found.append(f"corners miss their places by {fit.best.rms_px:.2f} px: the board is not flat, was moving, or is not the one stated")
    if focal > REFUSED_FOCAL_SHARE:
        found.append(f"the focal length is only known to {focal:.1%}: the board was never tilted enough, or always far away")
    if centre > REFUSED_CENTRE_SHARE * width:
        found.append(f"the lens centre is only known to {centre:.1f} px: the board was seen on one side only")
    if error_m > REFUSED_ERROR_M:
        found.append(f"a point 1 m away would be placed wrong by {1e3 * error_m:.0f} mm")
    if reach < REFUSED_REACH:
        found.append(f"the board was seen in the inner {reach:.0%} of the picture only")
    if fit.camera.growing_to_rad <= fit.seen_to_rad:
        found.append(
            f"the lens that fits folds back {np.degrees(fit.camera.growing_to_rad):.0f} degrees from the axis, where corners were seen"
        )
    return found


def _doubts(fit: LensFit, field: Field, error_m: float, reach: float) -> tuple[list[str], list[str]]:
    """Return what makes a calibration less than good, and what to do about it."""
    doubts, advice = [], []
    if fit.best.rms_px > DOUBTFUL_RMS_SHARE * fit.size_px[0]:
        doubts.append(f"corners miss their places by {fit.best.rms_px:.2f} px")
        advice.append("glue the board to something flat, hold board and camera still, and give light")
    if error_m > DOUBTFUL_ERROR_M:
        doubts.append(f"a point 1 m away is placed wrong by {1e3 * error_m:.1f} mm")
        advice.append("take more photos, with the board near and tilted by 30 to 45 degrees to different sides")
    if len(fit.used) < ENOUGH_PICTURES:
        doubts.append(f"only {len(fit.used)} different photos count")
        advice.append(f"take at least {ENOUGH_PICTURES}, 20 are better")
    if reach < DOUBTFUL_REACH:
        doubts.append(f"the board was seen in the inner {reach:.0%} of the picture only: farther out the lens is a guess")
        advice.append("hold the board near the rim, close to the lens and facing it")
    elif empty := empty_sectors(fit, field.radius_px):
        doubts.append(f"the board was never near the rim towards the {', '.join(empty)}")
        advice.append("hold the board there too")
    if not field.is_circle and field.half_angle_rad >= fit.camera.growing_to_rad - 1e-6:
        doubts.append("towards the picture's corners the lens that fits stops telling directions")
        advice.append("hold the board into the picture's corners")
    return doubts, advice


def _seen_radius_px(fit: LensFit) -> float:
    focal = fit.camera.values[:2]
    offset = (np.concatenate(fit.corners) - fit.camera.values[2:FRAME]) / focal * focal[0]
    return float(np.hypot(offset[:, 0], offset[:, 1]).max())
