"""The doctor on the calibration: whether it can be read, how old it is, and whether it is this robot's own."""

from __future__ import annotations

import time
from pathlib import Path

from agent.calibration import read_calibration
from agent.doctor.finding import Finding, bad, good, warning
from agent.rig import Calibration
from protocol.errors import ConfigError

OLD_DAYS = 365.0
_DAY_S = 86_400.0
_AS_DRAWN = "as drawn"  # in the first line of the calibration that is installed with the package
_CALIBRATE = "take photos of a board and run: ommatidia calibrate lens PHOTOS"


def examine_calibration(file: Path, now_s: float | None = None) -> tuple[Calibration | None, list[Finding]]:
    """Return the calibration, None where it cannot be used, and what there is to say of it; `now_s` is on the wall clock."""
    try:
        calibration = read_calibration(file)
        text = file.read_text(encoding="utf-8")
    except ConfigError as error:
        return None, [bad("calibration", "cannot be used", str(error), _CALIBRATE)]
    size = f"{calibration.width_px}x{calibration.height_px}, camera {calibration.camera_height_m:.3f} m over the floor"
    if _AS_DRAWN in text.partition("\n")[0]:
        return calibration, [warning("calibration", size, "it is the drawing's, not this camera's own", _CALIBRATE)]
    age_days = ((time.time() if now_s is None else now_s) - file.stat().st_mtime) / _DAY_S
    if age_days > OLD_DAYS:
        return calibration, [warning("calibration", f"{size}, {age_days:.0f} days old", "lenses and mounts move with time", _CALIBRATE)]
    return calibration, [good("calibration", f"{size}, {max(age_days, 0.0):.0f} days old")]
