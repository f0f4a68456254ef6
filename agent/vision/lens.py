"""Two lenses: Kannala-Brandt as calibrated, and the hemispherical model of the paper (Eq. 6 and 7).

Camera frame: x along +u (image right), y along +v (image down), z along the optical axis. The top-left pixel's centre is (0, 0).
Each model's two directions undo each other where it holds, and answer NaN, never a wild number, where it does not.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from protocol.errors import GeometryError
from protocol.geometry import Array

HALF_FIELD_RAD = math.radians(92.5)  # half of the 185 degree view

_TABLE_NODES = 4096
_MIN_SLOPE = 0.05  # where the radius grows more slowly than this with the angle, a pixel no longer tells a direction
_ROUNDING = 1e-12  # lets the very border of the field survive a round trip
_TINY = 1e-300  # stands in for a zero divisor whose numerator is zero too


class Lens(Protocol):
    """Where a ray of light falls on the picture, and back."""

    def project(self, rays: ArrayLike) -> Array:
        """Map rays of any length, shape (..., 3) [camera], to pixels (..., 2) [px]; NaN where the lens does not see them."""

    def unproject(self, pixels: ArrayLike) -> Array:
        """Map pixels, shape (..., 2) [px], to unit rays (..., 3) [camera]; NaN outside the image circle."""


@dataclass(frozen=True)
class KannalaBrandt:
    """The radius on the picture as an odd polynomial of the angle theta to the optical axis.

    theta_d = theta + k1 theta^3 + k2 theta^5 + k3 theta^7 + k4 theta^9; u = fx theta_d cos(phi) + cx; v = fy theta_d sin(phi) + cy.
    Source: Kannala and Brandt, "A generic camera model and calibration method", PAMI 2006, in OpenCV's parametrisation.
    Valid up to `max_angle_rad`, or up to where theta_d stops growing with theta, whichever comes first.
    Raises GeometryError where a parameter is not finite or a focal length is not positive.
    """

    fx: float  # [px / rad]
    fy: float
    cx: float  # [px]
    cy: float
    k1: float = 0.0
    k2: float = 0.0
    k3: float = 0.0
    k4: float = 0.0
    max_angle_rad: float = HALF_FIELD_RAD

    def __post_init__(self) -> None:
        """Refuse parameters that describe no lens."""
        values = (self.fx, self.fy, self.cx, self.cy, self.k1, self.k2, self.k3, self.k4, self.max_angle_rad)
        if not all(map(math.isfinite, values)):
            raise GeometryError(f"Kannala-Brandt lens: every parameter must be a finite number, not {values}")
        if not (self.fx > 0.0 and self.fy > 0.0 and 0.0 < self.max_angle_rad <= math.pi):
            raise GeometryError(
                f"Kannala-Brandt lens: focal lengths and angle must be positive, not {self.fx}, {self.fy}, {self.max_angle_rad}"
            )

    @cached_property
    def field_angle_rad(self) -> float:
        """The largest angle to the axis that has a pixel of its own."""
        return float(self._table[0][-1])

    def project(self, rays: ArrayLike) -> Array:
        """Map rays of any length, shape (..., 3) [camera], to pixels (..., 2) [px]; NaN beyond the field, and for a ray without length."""
        ray = np.asarray(rays, dtype=np.float64)
        x, y, z = ray[..., 0], ray[..., 1], ray[..., 2]
        off_axis = np.hypot(x, y)
        theta = np.arctan2(off_axis, z)
        seen = (theta <= self.field_angle_rad + _ROUNDING) & ((off_axis > 0.0) | (z > 0.0))
        scale = np.where(seen, self._radius(theta), np.nan) / np.maximum(off_axis, _TINY)
        return np.stack([self.fx * (scale * x) + self.cx, self.fy * (scale * y) + self.cy], axis=-1)

    def unproject(self, pixels: ArrayLike) -> Array:
        """Map pixels, shape (..., 2) [px], to unit rays (..., 3) [camera]; NaN outside the image circle."""
        pixel = np.asarray(pixels, dtype=np.float64)
        x, y = (pixel[..., 0] - self.cx) / self.fx, (pixel[..., 1] - self.cy) / self.fy
        theta_d = np.hypot(x, y)
        theta = self._angle(theta_d)
        scale = np.sin(theta) / np.maximum(theta_d, _TINY)
        return np.stack([scale * x, scale * y, np.cos(theta)], axis=-1)

    @cached_property
    def _table(self) -> tuple[Array, Array]:
        """Angles [rad] and their theta_d at equal steps of the angle, as far as theta_d grows.

        Linear interpolation of theta over theta_d errs by at most step^2 / 8 * max|theta_d''| / slope, below 1e-7 rad for a usual lens.
        """
        theta = np.linspace(0.0, self.max_angle_rad, _TABLE_NODES)
        flat = np.flatnonzero(self._slope(theta) < _MIN_SLOPE)
        end = int(flat[0]) if flat.size else _TABLE_NODES
        return theta[:end], self._radius(theta[:end])

    def _angle(self, theta_d: Array) -> Array:
        """Invert the polynomial: the table's answer and one Newton step, which squares its error."""
        angles, radii = self._table
        theta = np.interp(theta_d, radii, angles)
        theta -= (self._radius(theta) - theta_d) / self._slope(theta)
        return np.where(theta_d <= radii[-1] + _ROUNDING, theta, np.nan)

    def _radius(self, theta: Array) -> Array:
        s = theta * theta
        return np.asarray(theta * (1.0 + s * (self.k1 + s * (self.k2 + s * (self.k3 + s * self.k4)))))

    def _slope(self, theta: Array) -> Array:
        s = theta * theta
        return np.asarray(1.0 + s * (3.0 * self.k1 + s * (5.0 * self.k2 + s * (7.0 * self.k3 + s * (9.0 * self.k4)))))


@dataclass(frozen=True)
class Hemispherical:
    """The paper's semispherical model (its Fig. 7): the picture is the hemisphere of rays seen from above, F pixels in radius.

    A ray at angle theta to the axis falls at radius r_d = F sin(theta) and is corrected to r_u = F tan(theta), so nothing is seen at or
    beyond 90 degrees. Raises GeometryError where a parameter is not finite or F is not positive.
    """

    F: float  # radius of the picture at 90 degrees [px]
    cx: float  # [px]
    cy: float

    def __post_init__(self) -> None:
        """Refuse parameters that describe no lens."""
        if not all(map(math.isfinite, (self.F, self.cx, self.cy))) or self.F <= 0.0:
            raise GeometryError(f"hemispherical lens: needs a finite centre and a positive radius, not {self.F}, {self.cx}, {self.cy}")

    def correct(self, pixels: ArrayLike) -> Array:
        """Map pixels, shape (..., 2) [px], to corrected points (..., 2) [px from the centre]: what a pinhole camera would see; Eq. 6.

        NaN for r_d >= F.
        """
        offset = np.asarray(pixels, dtype=np.float64) - np.array([self.cx, self.cy])
        x_d, y_d = offset[..., 0], offset[..., 1]
        square = self.F**2 - (x_d**2 + y_d**2)
        length = self.F**2 / np.sqrt(np.where(square > 0.0, square, np.nan))  # Eq. 7
        return np.stack([x_d * length / self.F, y_d * length / self.F], axis=-1)

    def unproject(self, pixels: ArrayLike) -> Array:
        """Map pixels, shape (..., 2) [px], to unit rays (..., 3) [camera]; NaN for r_d >= F."""
        corrected = self.correct(pixels)
        rays = np.concatenate([corrected, np.full_like(corrected[..., :1], self.F)], axis=-1)
        return np.asarray(rays / np.linalg.norm(rays, axis=-1, keepdims=True))

    def project(self, rays: ArrayLike) -> Array:
        """Map rays of any length, shape (..., 3) [camera], to pixels (..., 2) [px]; NaN at and beyond 90 degrees from the axis."""
        ray = np.asarray(rays, dtype=np.float64)
        length = np.linalg.norm(ray, axis=-1, keepdims=True)
        before = ray[..., 2:] > 0.0
        offset = np.where(before, self.F * ray[..., :2] / np.maximum(length, _TINY), np.nan)
        return np.asarray(offset + np.array([self.cx, self.cy]))
