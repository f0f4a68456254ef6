"""Random arenas of four by three metres with a barrier, and how a mapped grid of them would look."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
import shapely
import shapely.affinity
from numpy.typing import NDArray

from mapserver.formation.floor import Bounds
from protocol.geometry import Array, Pose2
from protocol.messages import FREE, OCCUPIED

CELL_M = 0.01
BOUNDS = Bounds(0.0, 0.0, 4.0, 3.0)
ORIGIN_M = np.array(BOUNDS[:2])
SHAPE = (300, 400)
KEPT_FREE_M = 0.40  # between two things, so that wherever one looks there is a way or plainly none
BARRIER_M = 0.10


@dataclass(frozen=True)
class Arena:
    """Things on the floor, where the leader starts, and the goal [m]."""

    things: tuple[shapely.Polygon, ...]
    start: Pose2
    goal_m: tuple[float, float]
    gap_m: float

    def touches(self, place_m: Array, radius_m: float) -> bool:
        """Tell whether a disc touches a thing or leaves the arena."""
        point = shapely.Point(place_m)
        beyond = not shapely.box(*BOUNDS).buffer(-radius_m + 1e-6).contains(point)
        return beyond or any(thing.distance(point) < radius_m for thing in self.things)

    def cells(self, grown_m: Array) -> NDArray[np.uint8]:
        """Return the grid of the arena, every thing's outline moved out by its share of `grown_m`, shape (things,)."""
        cells = np.full(SHAPE, FREE, np.uint8)
        for thing, margin_m in zip(self.things, grown_m, strict=True):
            corners = shapely.get_coordinates(thing.buffer(float(margin_m), join_style="mitre").exterior)[:-1]
            cv2.fillPoly(cells, [np.rint(((corners - ORIGIN_M) / CELL_M - 0.5) * 16).astype(np.int32)], OCCUPIED, shift=4)
        return cells


def random_arena(seed: int, back_m: float = 0.6) -> Arena:
    """Return an arena with a barrier between start and goal, whose gap is wider than a robot and narrower than a wedge.

    A swarm that reaches `back_m` behind its leader has room to be set down.
    """
    random = np.random.default_rng(seed)
    start = Pose2(0.25 + back_m, float(random.uniform(0.9, 2.1)), float(random.uniform(-0.3, 0.3)))
    goal_m = (float(random.uniform(3.45, 3.6)), float(random.uniform(0.5, 2.5)))
    gap_m, middle_m = float(random.uniform(0.32, 0.5)), float(random.uniform(0.6, 2.4))
    barrier_x_m = float(random.uniform(1.9, 2.3))
    things = list(_barrier(barrier_x_m, middle_m, gap_m))
    mouth = shapely.LineString([(barrier_x_m - 0.5, middle_m), (barrier_x_m + 0.5, middle_m)])
    free = [_around(start, back_m).buffer(0.12), shapely.Point(goal_m).buffer(0.35), mouth.buffer(0.25)]
    wanted = int(random.integers(8, 13))
    for _ in range(400):
        if len(things) == wanted:
            break
        thing = _random_thing(random)
        inside = shapely.box(*BOUNDS).buffer(-KEPT_FREE_M).contains(thing)
        if inside and all(thing.distance(other) >= KEPT_FREE_M for other in things) and not any(thing.intersects(area) for area in free):
            things.append(thing)
    return Arena(tuple(things), start, goal_m, gap_m)


def _barrier(x_m: float, middle_m: float, gap_m: float) -> tuple[shapely.Polygon, shapely.Polygon]:
    left_m, right_m = x_m - 0.5 * BARRIER_M, x_m + 0.5 * BARRIER_M
    lower = shapely.box(left_m, BOUNDS.y_min_m, right_m, middle_m - 0.5 * gap_m)
    return lower, shapely.box(left_m, middle_m + 0.5 * gap_m, right_m, BOUNDS.y_max_m)


def _around(start: Pose2, back_m: float) -> shapely.Geometry:
    """Return the floor on which the swarm is set down."""
    return shapely.Polygon(start.apply([[0.3, 0.0], [0.0, 0.3], [-back_m, 0.6], [-back_m, -0.6], [0.0, -0.3]]))


def _random_thing(random: np.random.Generator) -> shapely.Polygon:
    centre = shapely.Point(random.uniform(BOUNDS[0], BOUNDS[2]), random.uniform(BOUNDS[1], BOUNDS[3]))
    if random.random() < 0.5:
        return centre.buffer(float(random.uniform(0.05, 0.14)))
    width_m, depth_m, turn_rad = random.uniform(0.1, 0.35), random.uniform(0.1, 0.3), random.uniform(0.0, math.pi)
    box = shapely.box(centre.x - 0.5 * width_m, centre.y - 0.5 * depth_m, centre.x + 0.5 * width_m, centre.y + 0.5 * depth_m)
    return shapely.affinity.rotate(box, turn_rad, use_radians=True)
