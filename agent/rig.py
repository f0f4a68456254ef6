"""What one robot is made of: the lengths that the estimator needs, as plain values."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Body:
    """The robot's upright cylinder, and its wheels. All robots of a swarm are taken to have the same body."""

    body_radius_m: float
    body_height_m: float  # the outer edge of the rim that the camera sees in the picture's middle
    wheel_base_m: float
    wheel_radius_m: float
    deck_radius_m: float | None = None  # the disc inside that rim
    deck_height_m: float | None = None


@dataclass(frozen=True)
class Calibration:
    """The fisheye camera: Kannala-Brandt intrinsics, and where the camera sits on the body."""

    width_px: int
    height_px: int
    focal_px: tuple[float, float]  # fx, fy
    centre_px: tuple[float, float]  # cx, cy; the centre of the top-left pixel is (0, 0)
    distortion: tuple[float, float, float, float]  # k1..k4
    field_of_view_rad: float
    body_from_camera: NDArray[np.float64]  # (4, 4), T_BS
    readout_s: float = 0.0  # from the first row to the last, where the shutter rolls; a picture's stamp is that of its middle row

    @property
    def camera_height_m(self) -> float:
        """Height of the camera above the floor."""
        return float(self.body_from_camera[2, 3])
