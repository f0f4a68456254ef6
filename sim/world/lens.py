"""Lenses of the simulated world: how a ray falls on the picture, and back. Written for the world alone, not shared with any robot.

Camera frame: x to the picture's right, y down, z along the optical axis. The centre of the top left pixel is (0, 0).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from protocol.geometry import Array

_NEWTON_STEPS = 8
_SMALL = 1e-12


class Lens(Protocol):
    """A central projection that is symmetric about its axis."""

    @property
    def widest_rad(self) -> float:
        """The largest angle to the axis that the picture shows."""
        ...

    @property
    def px_per_rad(self) -> float:
        """How many pixels an angle of one radian takes in the picture's middle."""
        ...

    def pixels(self, points: Array) -> Array:
        """Return the pixels (..., 2) of points (..., 3) [camera]; what lies beyond the field falls on its border, in its direction."""
        ...

    def rays(self, pixels: Array) -> Array:
        """Return unit rays (..., 3) [camera] of pixels (..., 2); NaN beyond the field."""
        ...


@dataclass(frozen=True)
class RadialLens:
    """A fisheye lens: the angle to the axis alone tells the radius. Base of the models below, which give `_radius` and `_angle`."""

    fx: float
    fy: float
    cx: float
    cy: float
    fov_rad: float  # whole field

    @property
    def widest_rad(self) -> float:
        """The largest angle to the axis that the picture shows."""
        return 0.5 * self.fov_rad

    @property
    def px_per_rad(self) -> float:
        """How many pixels an angle of one radian takes in the picture's middle."""
        return min(self.fx, self.fy)

    def pixels(self, points: Array) -> Array:
        """Return the pixels of points; see `Lens`."""
        points = np.asarray(points, dtype=np.float64)
        x, y, z = points[..., 0], points[..., 1], points[..., 2]
        off_axis = np.hypot(x, y)
        radius = self._radius(np.minimum(np.arctan2(off_axis, z), self.widest_rad)) / np.maximum(off_axis, _SMALL)
        return np.stack([self.cx + self.fx * radius * x, self.cy + self.fy * radius * y], axis=-1)

    def rays(self, pixels: Array) -> Array:
        """Return the rays of pixels; see `Lens`."""
        u, v = np.moveaxis(np.asarray(pixels, dtype=np.float64), -1, 0)
        x, y = (u - self.cx) / self.fx, (v - self.cy) / self.fy
        radius = np.hypot(x, y)
        angle = self._angle(radius)
        angle = np.where(angle <= self.widest_rad, angle, np.nan)
        sine = np.sin(angle) / np.maximum(radius, _SMALL)
        return np.stack([sine * x, sine * y, np.cos(angle)], axis=-1)

    def _radius(self, angle_rad: Array) -> Array:
        raise NotImplementedError

    def _angle(self, radius: Array) -> Array:
        raise NotImplementedError


@dataclass(frozen=True)
class KannalaBrandtLens(RadialLens):
    """radius = t + k1 t^3 + k2 t^5 + k3 t^7 + k4 t^9 at the angle t (Kannala and Brandt, PAMI 2006, eq. 6)."""

    coefficients: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)

    def _radius(self, angle_rad: Array) -> Array:
        powers = [angle_rad ** (2 * order + 3) for order in range(4)]
        return angle_rad + sum(k * power for k, power in zip(self.coefficients, powers, strict=True))

    def _angle(self, radius: Array) -> Array:
        angle = radius.copy()
        for _ in range(_NEWTON_STEPS):
            slope = 1.0 + sum((2 * order + 3) * k * angle ** (2 * order + 2) for order, k in enumerate(self.coefficients))
            angle = angle - (self._radius(angle) - radius) / slope
        return angle


@dataclass(frozen=True)
class HemisphericalLens(RadialLens):
    """The paper's model: the picture is a hemisphere of rays seen from above, radius = sin t (its Fig. 7, before Eq. 6)."""

    @property
    def widest_rad(self) -> float:
        """The largest angle to the axis that the picture shows: a right angle at most."""
        return min(0.5 * self.fov_rad, 0.5 * math.pi)

    def _radius(self, angle_rad: Array) -> Array:
        return np.sin(np.minimum(angle_rad, 0.5 * np.pi))

    def _angle(self, radius: Array) -> Array:
        return np.arcsin(np.where(radius <= 1.0, radius, np.nan))


@dataclass(frozen=True)
class PinholeLens(RadialLens):
    """radius = tan t, for cameras that look at a part of the room from outside."""

    def _radius(self, angle_rad: Array) -> Array:
        return np.tan(angle_rad)

    def _angle(self, radius: Array) -> Array:
        return np.arctan(radius)
