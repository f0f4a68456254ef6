"""Other robots as things that are known: what they hide, and what floor they surely cover."""

from __future__ import annotations

import math
from typing import NamedTuple, Self

import numpy as np

from mapserver.mapping.belief import Belief
from protocol.geometry import Array

ROBOT_MARGIN_M = 0.03  # contact shadow and soft edges around a robot's base
MOST_UNCERTAINTY_M = 0.1  # a lost robot hides no more than this beyond its rim
BODY_SHRINK_M = 0.01  # cells on a body's rim may belong to what it touches
_SECTOR_POINTS = 9


class Body(NamedTuple):
    """A robot as an upright cylinder that reaches above the camera."""

    position_m: Array  # shape (2,) [m; arena]
    radius_m: float
    uncertainty_m: float  # two standard deviations of the position

    @classmethod
    def of(cls, belief: Belief, radius_m: float) -> Self:
        """Return the body of a robot where it is believed to be."""
        deviation_m = math.sqrt(float(np.linalg.eigvalsh(belief.position_covariance())[-1]))
        return cls(np.array(belief.arena_from_body[:2]), radius_m, 2.0 * deviation_m)

    def shadow_radius_m(self) -> float:
        """Return the radius within which another robot's view may show this one, contact shadow included."""
        return self.radius_m + ROBOT_MARGIN_M + min(self.uncertainty_m, MOST_UNCERTAINTY_M)

    def core_radius_m(self) -> float:
        """Return the radius that the body certainly covers; 0 where its place is too uncertain."""
        return max(self.radius_m - BODY_SHRINK_M - self.uncertainty_m, 0.0)


def robot_sector(eye_m: Array, body: Body, reach_m: float) -> Array | None:
    """Return the polygon, shape (n, 2) [m; arena], that a robot hides: from its near base arc outward to `reach_m`.

    The body is a cylinder taller than the camera, so its smear has no end. None where the eye lies within the body.
    """
    offset = body.position_m - eye_m
    distance_m = float(np.hypot(*offset))
    radius_m = body.shadow_radius_m()
    if distance_m <= radius_m:
        return None
    direction_rad = math.atan2(offset[1], offset[0])
    half_rad = math.asin(radius_m / distance_m)
    turn = np.linspace(-1.0, 1.0, _SECTOR_POINTS)
    near = body.position_m - radius_m * _unit(direction_rad - turn * (0.5 * math.pi - half_rad))
    between_rad = 2.0 * half_rad / (_SECTOR_POINTS - 1)
    far = eye_m + reach_m / math.cos(0.5 * between_rad) * _unit(direction_rad - turn * half_rad)
    return np.vstack([near, far])


def _unit(angle_rad: Array) -> Array:
    return np.stack([np.cos(angle_rad), np.sin(angle_rad)], axis=-1)
