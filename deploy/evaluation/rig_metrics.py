"""The rigs that the robots found themselves to have, beside the true ones of ground_truth/rig.yaml."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from pydantic import BaseModel, Field, FiniteFloat

from deploy.evaluation.reading import read_yaml
from protocol.messages import RigValue

Length = Annotated[FiniteFloat, Field(gt=0.0)]
RIG_FILE = Path("ground_truth", "rig.yaml")


@dataclass(frozen=True)
class RigScore:
    """By how much one robot's rig was missed."""

    height_percent: float
    tilt_deg: float
    centre_px: float
    focal_percent: float
    offset_mm: float
    radius_percent: float  # of the worse wheel
    base_percent: float
    lag_ms: float


class _TrueRig(BaseModel):
    name: str
    camera_height_m: Length
    T_BS: Annotated[tuple[FiniteFloat, ...], Field(min_length=16, max_length=16)]
    intrinsics: tuple[Length, Length, FiniteFloat, FiniteFloat]
    wheel_radius_left_m: Length
    wheel_radius_right_m: Length
    wheel_base_m: Length


class _TrueRigs(BaseModel):
    robots: Annotated[list[_TrueRig], Field(min_length=1)]
    wheel_stamp_offset_s: FiniteFloat = 0.0


def score_rigs(found: Mapping[str, tuple[RigValue, ...]], recording: Path) -> dict[str, RigScore]:
    """Return the score of every robot that tells of its rig and whose true rig is known; RecordingError where the file cannot be used."""
    if not (recording / RIG_FILE).exists():
        return {}
    true = read_yaml(recording / RIG_FILE, _TrueRigs)
    values = {robot: {each.name: each.value for each in rig} for robot, rig in found.items()}
    return {rig.name: _score(values[rig.name], rig, true.wheel_stamp_offset_s) for rig in true.robots if _has_scale(values, rig.name)}


def _has_scale(values: Mapping[str, Mapping[str, float]], robot: str) -> bool:
    return "wheel_base_m" in values.get(robot, {})


def _score(found: Mapping[str, float], true: _TrueRig, lag_s: float) -> RigScore:
    axis = true.T_BS[2], true.T_BS[6]  # of the lens, along x and y of the body
    tilt_rad = math.dist((found["camera_tilt_forward_rad"], found["camera_tilt_left_rad"]), axis)
    radii = [_percent(found[f"wheel_radius_{side}_m"], length) for side, length in _radii(true)]
    return RigScore(
        height_percent=_percent(found["camera_height_m"], true.camera_height_m),
        tilt_deg=math.degrees(tilt_rad),
        centre_px=math.dist((found["centre_u_px"], found["centre_v_px"]), true.intrinsics[2:]),
        focal_percent=_percent(found["focal_px"], true.intrinsics[0]),
        offset_mm=1e3 * math.dist((found["camera_offset_x_m"], found["camera_offset_y_m"]), (true.T_BS[3], true.T_BS[7])),
        radius_percent=max(radii),
        base_percent=_percent(found["wheel_base_m"], true.wheel_base_m),
        lag_ms=1e3 * abs(found["wheel_lag_s"] - lag_s),
    )


def _radii(true: _TrueRig) -> tuple[tuple[str, float], tuple[str, float]]:
    return ("left", true.wheel_radius_left_m), ("right", true.wheel_radius_right_m)


def _percent(found: float, true: float) -> float:
    return 100.0 * abs(found / true - 1.0)
