"""The doctor on the calibration: whether it can be read, how old it is, what it is worth, and whether it is this robot's own."""

from __future__ import annotations

import time
from datetime import datetime
from pathlib import Path
from typing import Any

import yaml

from agent.calibration import read_calibration
from agent.doctor.finding import Finding, bad, good, warning
from agent.rig import Calibration
from protocol.errors import ConfigError

OLD_DAYS = 365.0
AS_DRAWN = "as drawn"  # the verdict in the file that is installed with the package
_DAY_S = 86_400.0
_CALIBRATE = "take photos of a board and run: ommatidia calibrate lens PHOTOS"


def examine_calibration(file: Path, now_s: float | None = None) -> tuple[Calibration | None, list[Finding]]:
    """Return the calibration, None where it cannot be used, and what there is to say of it; `now_s` is on the wall clock."""
    try:
        calibration = read_calibration(file)
    except ConfigError as error:
        return None, [bad("calibration", "cannot be used", str(error), _CALIBRATE)]
    size = f"{calibration.width_px}x{calibration.height_px}, camera {calibration.camera_height_m:.3f} m over the floor"
    account = yaml.safe_load(file.read_text(encoding="utf-8")).get("calibration") or {}
    made_s = _made_s(file, account)
    return calibration, [_judge(size, account, ((time.time() if now_s is None else now_s) - made_s) / _DAY_S)]


def _judge(size: str, account: dict[str, Any], age_days: float) -> Finding:
    """Return what a calibration is worth by what it says of itself, so many days after it was made."""
    verdict = str(account.get("verdict", ""))
    if verdict == AS_DRAWN:
        return warning("calibration", size, "it is the drawing's, not this camera's own", _CALIBRATE)
    seen = f"{size}, {max(age_days, 0.0):.0f} days old{f', found to be {verdict}' if verdict else ''}"
    if verdict not in ("", "good"):
        return warning("calibration", seen, "; ".join(map(str, account.get("reasons", []))) or "its photos told too little", _CALIBRATE)
    if age_days > OLD_DAYS:
        return warning("calibration", seen, "lenses and mounts move with time", _CALIBRATE)
    return good("calibration", seen)


def _made_s(file: Path, account: dict[str, Any]) -> float:
    """Return when a calibration was made, on the wall clock: as it says itself, or when its file was written."""
    try:
        return datetime.fromisoformat(str(account.get("date"))).timestamp()
    except ValueError:
        return file.stat().st_mtime
