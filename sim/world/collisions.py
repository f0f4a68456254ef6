"""What a round body runs into: its clearance from convex things and other bodies, and the count of its collisions."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from protocol.geometry import Array
from sim.world.scene import Thing

APART_M = 0.005  # a contact is over when so much room is between both

Point = tuple[float, float]


class Near(NamedTuple):
    """Something that a body could touch, and how far its edge is from two points [m], negative where a point is inside."""

    name: str
    before_m: float
    after_m: float


class Obstacles:
    """Convex things, prepared for being asked about again and again."""

    def __init__(self, things: Sequence[Thing]) -> None:
        self._names = [thing.name for thing in things]
        self._footprints = [thing.footprint_m for thing in things]
        lows = [footprint.min(axis=0) for footprint in self._footprints]
        highs = [footprint.max(axis=0) for footprint in self._footprints]
        self._lows, self._highs = np.reshape(lows, (-1, 2)), np.reshape(highs, (-1, 2))  # of the boxes around the footprints

    def near(self, before: Point, after: Point, reach_m: float) -> list[Near]:
        """Return what comes within reach of `after`."""
        outside = np.maximum(np.maximum(self._lows - after, after - self._highs), 0.0)
        close = np.flatnonzero((outside**2).sum(axis=1) <= reach_m**2)
        return [Near(self._names[i], clearance_m(before, self._footprints[i]), clearance_m(after, self._footprints[i])) for i in close]


class Contacts:
    """The contacts of one body: each begins when the body runs into something and ends when it has come away from it."""

    def __init__(self) -> None:
        self.count = 0  # contacts so far
        self._touched: frozenset[str] = frozenset()

    def meet(self, near: Iterable[Near], radius_m: float) -> list[str]:
        """Take note of what is near, and return what the body has run into just now."""
        near = list(near)
        hits = {other.name for other in near if is_blocked(other, radius_m)}
        held = {other.name for other in near if other.after_m - radius_m < APART_M}
        new = sorted(hits - self._touched)
        self._touched = frozenset(hits | (self._touched & held))
        self.count += len(new)
        return new


def is_blocked(other: Near, radius_m: float) -> bool:
    """Tell whether a body of this radius would move into something, or further into it."""
    return other.after_m < radius_m and other.after_m < other.before_m


def clearance_m(point: Point, footprint_m: Array) -> float:
    """Return the distance of a point from a convex counter-clockwise polygon (n, 2); negative inside: how deep below its nearest edge."""
    edges = np.roll(footprint_m, -1, axis=0) - footprint_m
    offsets = np.asarray(point) - footprint_m
    lengths = np.hypot(edges[:, 0], edges[:, 1])
    outside = (edges[:, 1] * offsets[:, 0] - edges[:, 0] * offsets[:, 1]) / lengths  # signed distance from each edge's line
    if outside.max() <= 0.0:
        return float(outside.max())
    along = np.clip((edges * offsets).sum(axis=1) / lengths**2, 0.0, 1.0)
    away = offsets - along[:, None] * edges
    return float(np.hypot(away[:, 0], away[:, 1]).min())


def body_clearance_m(point: Point, other: Point, other_radius_m: float) -> float:
    """Return the distance of a point from another round body's edge."""
    return math.dist(point, other) - other_radius_m
