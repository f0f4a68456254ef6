"""The footprints of a scenario's things: convex polygons on the floor, counter-clockwise, shape (n, 2) [m; arena]."""

from __future__ import annotations

import math

import numpy as np

from protocol.geometry import Array, Pose2
from sim.scenario import ArenaTable, BoxTable, CylinderTable

CYLINDER_SIDES = 32
WALL_THICKNESS_M = 0.05


def box_footprint(box: BoxTable) -> Array:
    """Return the four corners of a box."""
    half = 0.5 * np.array(box.size_m)
    corners = half * [(-1, -1), (1, -1), (1, 1), (-1, 1)]
    return Pose2(*box.centre_m, box.yaw_rad).apply(corners)


def cylinder_footprint(cylinder: CylinderTable) -> Array:
    """Return a regular polygon whose corners lie on the cylinder's circle."""
    return circle(cylinder.centre_m, cylinder.radius_m, CYLINDER_SIDES)


def circle(centre_m: tuple[float, float], radius_m: float, sides: int) -> Array:
    """Return a regular polygon with its corners on a circle."""
    angles = np.arange(sides) * (2.0 * math.pi / sides)
    return np.asarray(centre_m + radius_m * np.column_stack((np.cos(angles), np.sin(angles))))


def wall_footprints(arena: ArenaTable) -> list[Array]:
    """Return the four walls around an arena; they lie beyond its bounds and overlap nowhere."""
    x0, y0, x1, y1, t = arena.x_min_m, arena.y_min_m, arena.x_max_m, arena.y_max_m, WALL_THICKNESS_M
    sides = [(x0 - t, y0 - t, x1 + t, y0), (x0 - t, y1, x1 + t, y1 + t), (x0 - t, y0, x0, y1), (x1, y0, x1 + t, y1)]
    return [np.array([(left, low), (right, low), (right, high), (left, high)]) for left, low, right, high in sides]
