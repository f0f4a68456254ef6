"""Planar rigid motions, SE(2): the only pose algebra in the project.

A pose named `a_from_b` maps points of frame b into frame a: `p_a = a_from_b.apply(p_b)`.
Angles are counter-clockwise [rad], wrapped to (-pi, pi]. Lengths are metres.
Tangent vectors are (x, y, theta), expressed in the right-hand (body) frame: `a_from_b @ Pose2.exp(xi)`.
Source of the closed forms: Sola, Deray, Atchuthan, "A micro Lie theory for state estimation in robotics", example 4.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

_SMALL_ANGLE_RAD = 1e-9


def wrap_angle(angle_rad: float) -> float:
    """Return the same direction in (-pi, pi]."""
    wrapped = math.remainder(angle_rad, 2.0 * math.pi)
    return math.pi if wrapped == -math.pi else wrapped


class Pose2(NamedTuple):
    """A planar pose `a_from_b`: position of b's origin in a [m], and b's heading in a [rad]."""

    x_m: float
    y_m: float
    theta_rad: float

    @staticmethod
    def identity() -> Pose2:
        """Return the pose of a frame in itself."""
        return Pose2(0.0, 0.0, 0.0)

    def __matmul__(self, other: Pose2) -> Pose2:
        """Chain poses: a_from_c = a_from_b @ b_from_c."""
        cos, sin = math.cos(self.theta_rad), math.sin(self.theta_rad)
        return Pose2(
            self.x_m + cos * other.x_m - sin * other.y_m,
            self.y_m + sin * other.x_m + cos * other.y_m,
            wrap_angle(self.theta_rad + other.theta_rad),
        )

    def inverse(self) -> Pose2:
        """Return b_from_a."""
        cos, sin = math.cos(self.theta_rad), math.sin(self.theta_rad)
        return Pose2(
            -cos * self.x_m - sin * self.y_m,
            sin * self.x_m - cos * self.y_m,
            wrap_angle(-self.theta_rad),
        )

    def between(self, other: Pose2) -> Pose2:
        """Return b_from_c, given self = a_from_b and other = a_from_c."""
        return self.inverse() @ other

    def apply(self, points_b: ArrayLike) -> Array:
        """Map points, shape (..., 2) [m; frame b], into frame a, same shape."""
        points_a: Array = np.asarray(points_b, dtype=np.float64) @ self.rotation().T
        points_a[..., 0] += self.x_m
        points_a[..., 1] += self.y_m
        return points_a

    def rotation(self) -> Array:
        """Return the rotation matrix a_from_b, shape (2, 2)."""
        cos, sin = math.cos(self.theta_rad), math.sin(self.theta_rad)
        return np.array([[cos, -sin], [sin, cos]])

    def adjoint(self) -> Array:
        """Return the matrix, shape (3, 3), that carries tangents of b into tangents of a."""
        cos, sin = math.cos(self.theta_rad), math.sin(self.theta_rad)
        return np.array([[cos, -sin, self.y_m], [sin, cos, -self.x_m], [0.0, 0.0, 1.0]])

    @staticmethod
    def exp(tangent: ArrayLike) -> Pose2:
        """Return the pose reached by moving with constant twist `tangent` (x [m], y [m], theta [rad]) for one unit of time."""
        x, y, theta = np.asarray(tangent, dtype=np.float64).tolist()
        if abs(theta) < _SMALL_ANGLE_RAD:
            return Pose2(x, y, theta)
        a = math.sin(theta) / theta
        b = 2.0 * math.sin(0.5 * theta) ** 2 / theta  # (1 - cos) / theta, which would cancel for small angles
        return Pose2(a * x - b * y, b * x + a * y, wrap_angle(theta))

    def log(self) -> Array:
        """Return the constant twist, shape (3,), whose `exp` is this pose."""
        theta = wrap_angle(self.theta_rad)
        if abs(theta) < _SMALL_ANGLE_RAD:
            return np.array([self.x_m, self.y_m, theta])
        half = 0.5 * theta
        a = half / math.tan(half)
        return np.array([a * self.x_m + half * self.y_m, -half * self.x_m + a * self.y_m, theta])


def compose_covariance(cov_ab: Array, b_from_c: Pose2, cov_bc: Array) -> Array:
    """Return the covariance of a_from_b @ b_from_c, shape (3, 3), from independent ones in their right-hand frames.

    First order, both perturbations on the right, so a_from_b itself does not enter (Sola et al., eq. 54 to 56).
    """
    back = b_from_c.inverse().adjoint()
    return np.asarray(back @ cov_ab @ back.T + cov_bc)
