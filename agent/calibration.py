"""The camera's calibration on disk: sensor.yaml in the manner of the EuRoC datasets."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
import yaml
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, FiniteFloat

from agent.rig import Calibration
from protocol.errors import ConfigError
from protocol.geometry import Array
from protocol.settings import parse, read_text

Pixels = Annotated[int, Field(ge=16, le=16384)]
Focal = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]

_RIGID_TOLERANCE = 1e-4  # of the entries of R^T R - I: four written digits are enough
_MAX_HEIGHT_M = 5.0
_MAX_TILT_RAD = math.radians(45.0)  # beyond it the floor is no longer what the camera sees
_ANGLES_CHECKED = 256


class _Matrix(BaseModel):
    """A 4 x 4 matrix, row by row."""

    rows: Literal[4]
    cols: Literal[4]
    data: Annotated[tuple[FiniteFloat, ...], Field(min_length=16, max_length=16)]


class _SensorFile(BaseModel):
    """The fields of sensor.yaml that an agent needs; what else a dataset tells there is not its business."""

    model_config = ConfigDict(frozen=True)

    camera_model: Literal["kannala_brandt"]
    resolution: tuple[Pixels, Pixels]
    intrinsics: tuple[Focal, Focal, FiniteFloat, FiniteFloat]  # fx, fy, cx, cy
    distortion_coefficients: tuple[FiniteFloat, FiniteFloat, FiniteFloat, FiniteFloat]  # k1..k4
    readout_s: Annotated[float, Field(ge=0.0, le=0.2, allow_inf_nan=False)] = 0.0
    fov_deg: Annotated[float, Field(ge=10.0, le=240.0, allow_inf_nan=False)]
    T_BS: _Matrix


def read_calibration(file: Path) -> Calibration:
    """Return a camera's calibration; raises ConfigError that names file and field where it cannot be a downward fisheye camera."""
    sensor = parse(file, _document(file), _SensorFile)
    width_px, height_px = sensor.resolution
    fx, fy, cx, cy = sensor.intrinsics
    body_from_camera = np.array(sensor.T_BS.data).reshape(4, 4)
    fov_rad = math.radians(sensor.fov_deg)
    _check_centre(file, (cx, cy), (width_px, height_px))
    _check_lens(file, sensor.distortion_coefficients, fov_rad)
    _check_mount(file, body_from_camera)
    return Calibration(width_px, height_px, (fx, fy), (cx, cy), sensor.distortion_coefficients, fov_rad, body_from_camera, sensor.readout_s)


def _document(file: Path) -> dict[str, Any]:
    try:
        document = yaml.safe_load(read_text(file))
    except yaml.YAMLError as error:
        raise ConfigError(f"{file}: is not YAML: {' '.join(str(error).split())}") from None
    if not isinstance(document, dict):
        raise ConfigError(f"{file}: is no table of camera values")
    return document


def _check_centre(file: Path, centre_px: tuple[float, float], size_px: tuple[int, int]) -> None:
    if not all(0.0 <= at < size for at, size in zip(centre_px, size_px, strict=True)):
        raise ConfigError(f"{file}: `intrinsics`: the lens centre {centre_px} lies outside the {size_px[0]}x{size_px[1]} picture")


def _check_lens(file: Path, distortion: tuple[float, float, float, float], fov_rad: float) -> None:
    """Refuse a lens whose picture folds back: theta_d must grow with theta over the whole view."""
    theta = np.linspace(0.0, 0.5 * fov_rad, _ANGLES_CHECKED)
    slope = 1.0 + sum((2 * n + 3) * k * theta ** (2 * n + 2) for n, k in enumerate(distortion))
    if np.any(slope <= 0.0):
        degrees = math.degrees(theta[np.argmax(slope <= 0.0)])
        raise ConfigError(f"{file}: `distortion_coefficients`: the picture folds back at {degrees:.0f} degrees from the axis")


def _check_mount(file: Path, body_from_camera: NDArray[np.float64]) -> None:
    """Refuse a mount that is no rigid motion, or from which the floor cannot be seen."""
    if not _is_rigid(body_from_camera):
        raise ConfigError(
            f"{file}: `T_BS` is no rigid motion: its rotation is not orthonormal and right-handed, or its last row not 0 0 0 1"
        )
    height_m = body_from_camera[2, 3]
    if not 0.0 < height_m <= _MAX_HEIGHT_M:
        raise ConfigError(f"{file}: `T_BS` puts the camera {height_m:g} m above the floor; 0 to {_MAX_HEIGHT_M:g} m is possible")
    tilt_rad = math.acos(np.clip(-body_from_camera[2, 2], -1.0, 1.0))
    if tilt_rad > _MAX_TILT_RAD:
        raise ConfigError(f"{file}: `T_BS` has the camera look {math.degrees(tilt_rad):.0f} degrees away from straight down")


def _is_rigid(matrix: Array) -> bool:
    rotation = matrix[:3, :3]
    orthonormal = np.abs(rotation.T @ rotation - np.eye(3)).max() <= _RIGID_TOLERANCE
    return bool(orthonormal and np.linalg.det(rotation) > 0.0 and np.array_equal(matrix[3], [0.0, 0.0, 0.0, 1.0]))
