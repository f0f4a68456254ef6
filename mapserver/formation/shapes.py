"""The shapes of a formation: where followers stand, as offsets from the leader.

As in the paper's Fig. 12, a neighbour stands at distance d and at angle theta to the heading. An offset is (back, left): how far behind
the leader along its trail, and how far to the left of the trail.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from protocol.errors import GeometryError
from protocol.geometry import Array

Kind = Literal["line", "column", "wedge", "polygon", "free"]


@dataclass(frozen=True)
class Shape:
    """A shape for any number of robots; `offsets` are those of a free one, each (back, left) [m]."""

    kind: Kind
    distance_m: float = 0.45
    angle_rad: float = 0.7
    turn_rad: float = 0.0  # counter-clockwise about the leader
    scale: float = 1.0
    offsets: tuple[tuple[float, float], ...] = ()


def follower_offsets(shape: Shape, followers: int) -> Array:
    """Return the offsets of the first `followers` slots, shape (followers, 2) [m]. Raises GeometryError where one lies ahead."""
    if followers == 0:
        return np.zeros((0, 2))
    offsets = shape.scale * _upright(shape, followers) @ _turned(shape.turn_rad)
    if offsets[:, 0].min() < -1e-9:
        raise GeometryError(f"a {shape.kind} turned by {shape.turn_rad:g} rad puts a follower ahead of its leader")
    return offsets


def closest_pair_m(offsets: Array) -> float:
    """Return the least distance between any two robots of a formation, the leader in the origin."""
    places = np.vstack([np.zeros(2), offsets])
    apart = np.hypot(*(places[:, None] - places[None]).transpose(2, 0, 1))
    return float(apart[np.triu_indices(len(places), 1)].min(initial=math.inf))


def _upright(shape: Shape, followers: int) -> Array:
    ranks, sides = _ranks(followers)
    match shape.kind:
        case "column":
            return np.stack([shape.distance_m * np.arange(1, followers + 1), np.zeros(followers)], axis=1)
        case "line":
            return np.stack([np.zeros(followers), shape.distance_m * ranks * sides], axis=1)
        case "wedge":
            reach = shape.distance_m * ranks
            return np.stack([reach * math.cos(shape.angle_rad), reach * math.sin(shape.angle_rad) * sides], axis=1)
        case "polygon":
            return _polygon(shape.distance_m, followers)
        case "free":
            if followers > len(shape.offsets):
                raise GeometryError(f"{followers} followers, but only {len(shape.offsets)} free offsets")
            return np.array(shape.offsets[:followers])


def _ranks(followers: int) -> tuple[Array, Array]:
    """Return how far out each follower stands, 1, 1, 2, 2 ..., and on which side, left first."""
    numbers = np.arange(followers)
    return np.asarray(1.0 + numbers // 2), np.asarray(1.0 - 2.0 * (numbers % 2))


def _polygon(side_m: float, followers: int) -> Array:
    """Return the corners of a regular polygon with this side behind the leader's own corner."""
    corners = followers + 1
    radius_m = side_m / (2.0 * math.sin(math.pi / corners))
    angles = 2.0 * math.pi * np.arange(1, corners) / corners
    return radius_m * np.stack([1.0 - np.cos(angles), np.sin(angles)], axis=1)


def _turned(turn_rad: float) -> Array:
    """Return the matrix that turns rows (back, left) counter-clockwise as seen from above, where x is forward, that is -back."""
    cos, sin = math.cos(turn_rad), math.sin(turn_rad)
    return np.array([[cos, -sin], [sin, cos]])
