"""The calibration file that an agent reads, sensor.yaml, as written from a lens calibration."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from agent.calibration import read_calibration
from agent.lens_calibration.calibration import LensCalibration
from agent.lens_calibration.camera import FRAME
from agent.lens_calibration.fit import as_kannala_brandt

WIDEST_DEG = 240.0
_KEPT = ("rate_hz", "readout_s", "T_BS")  # of another sensor.yaml: what the lens does not tell
_DEFAULT_RATE_HZ = 10


def write_sensor_file(calibration: LensCalibration, file: Path, now: datetime, height_m: float, mount: Path | None) -> float:
    """Write the lens as Kannala-Brandt, and return by how much that lens draws at most differently from the one found [px].

    The camera is taken to look straight down from a height above the robot's centre, unless `mount`, another sensor.yaml, tells where it
    sits. ConfigError where that file cannot be used, or the agent could not read what was written.
    """
    half_angle = min(calibration.field.half_angle_rad, np.radians(0.5 * WIDEST_DEG))
    lens, off_px = as_kannala_brandt(calibration.fit.camera, half_angle)
    document = {
        "sensor_type": "camera",
        "comment": "written by ommatidia calibrate lens",
        "T_BS": _straight_down(height_m),
        "rate_hz": _DEFAULT_RATE_HZ,
        "resolution": list(calibration.fit.size_px),
        "camera_model": "kannala_brandt",
        "intrinsics": [round(float(value), 4) for value in lens.values[:FRAME]],
        "distortion_coefficients": [round(float(value), 8) for value in lens.values[FRAME:]],
        "fov_deg": round(float(np.degrees(2.0 * min(half_angle, lens.growing_to_rad))), 1),
        "calibration": _account(calibration, now),
    }
    document |= _kept(mount)
    file.write_text(yaml.safe_dump(document, sort_keys=False, default_flow_style=None, width=120), encoding="utf-8")
    read_calibration(file)
    return off_px


def _account(calibration: LensCalibration, now: datetime) -> dict[str, Any]:
    """Return what the calibration is worth, for whoever looks at the file later."""
    verdict, board = calibration.verdict, calibration.fit.board
    return {
        "date": now.isoformat(timespec="seconds"),
        "verdict": verdict.grade,
        "rms_px": round(verdict.rms_px, 4),
        "photos": verdict.pictures,
        "board": [board.columns, board.rows],
        "square_m": board.square_m,
        "seen_to_deg": round(verdict.seen_to_deg, 1),
        "error_at_1m_m": round(verdict.error_at_1m_m, 5),
        "model": calibration.fit.camera.family.name,
        "reasons": list(verdict.reasons),
    }


def _straight_down(height_m: float) -> dict[str, Any]:
    """Return a mount above the robot's centre: image up is forward, image left is left."""
    return {"rows": 4, "cols": 4, "data": [0.0, -1.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0, height_m, 0.0, 0.0, 0.0, 1.0]}


def _kept(mount: Path | None) -> dict[str, Any]:
    """Return what another calibration file says of everything but the lens."""
    if mount is None:
        return {}
    read_calibration(mount)
    document = yaml.safe_load(mount.read_text(encoding="utf-8"))
    return {key: document[key] for key in _KEPT if key in document}
