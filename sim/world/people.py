"""People who walk through: each is two legs, elliptic prisms that swing past each other along a line of way-points."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from protocol.geometry import Array, Pose2
from sim.world.scene import Rgb, Thing

LEG_HEIGHT_M = 0.45
LEG_HALF_SIZE_M = (0.12, 0.05)  # along and across the way
LEGS_APART_M = 0.18
STRIDE_M = 0.8  # the way of one leg's swing

_SIDES = 12


@dataclass(frozen=True)
class Walker:
    """Appears at the first way-point, walks, and is gone at the last one."""

    name: str
    way_m: Array  # (n, 2) way-points [arena]
    speed_m_s: float
    starts_at_s: float
    rgb: Rgb

    def legs(self, time_s: float) -> tuple[Thing, ...]:
        """Return both legs at a time since the world's start; none while nobody walks."""
        walked_m = (time_s - self.starts_at_s) * self.speed_m_s
        if not 0.0 <= walked_m <= _length_m(self.way_m):
            return ()
        strides, swing = divmod(walked_m / STRIDE_M, 1.0)
        left_m, right_m = (STRIDE_M * (strides + part) for part in (min(2.0 * swing, 1.0), max(2.0 * swing - 1.0, 0.0)))
        return (self._leg("left", left_m, 0.5 * LEGS_APART_M), self._leg("right", right_m, -0.5 * LEGS_APART_M))

    def _leg(self, which: str, along_m: float, aside_m: float) -> Thing:
        arena_from_leg = _pose_on(self.way_m, along_m) @ Pose2(0.0, aside_m, 0.0)
        angles = np.arange(_SIDES) * (2.0 * math.pi / _SIDES)
        footprint_m = arena_from_leg.apply(np.column_stack((np.cos(angles), np.sin(angles))) * LEG_HALF_SIZE_M)
        return Thing(f"{self.name}-{which}", "person", footprint_m, LEG_HEIGHT_M, self.rgb, "plain")


def _length_m(way_m: Array) -> float:
    return float(np.hypot(*np.diff(way_m, axis=0).T).sum())


def _pose_on(way_m: Array, along_m: float) -> Pose2:
    """Return the place on a way after so many metres, facing along it; beyond the last way-point straight on."""
    for (x0, y0), (x1, y1) in pairwise(way_m.tolist()):
        length_m = math.hypot(x1 - x0, y1 - y0)
        arena_from_leg = Pose2(x0, y0, math.atan2(y1 - y0, x1 - x0)) @ Pose2(along_m, 0.0, 0.0)
        if along_m <= length_m:
            break
        along_m -= length_m
    return arena_from_leg
