"""How a formation gives way: followers draw in to the trail where it is narrow.

How far is a smooth function of arc length, so that a follower draws in before it reaches the narrow place, and opens once it is through.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import minimum_filter1d, uniform_filter1d

from mapserver.formation.costmap import CostMap
from mapserver.formation.trail import STEP_M, Lane, sample
from protocol.geometry import Array

LATERAL_STEP_M = 0.02
SIDE_MARGIN_M = 0.045  # between a follower's body and things beside the trail
LEAST_STRETCH = 0.1  # on the inside of a bend no lane gets shorter than this share of the trail: nobody drives backwards
SLOPE, EASE_M = 1.0, 0.10  # of a lane that leaves the trail or comes back to it, and over how much of the trail it turns so far
BLEND_M = 0.45  # of trail, over which a new plan takes over from the old one


def lefts_along(trail: Lane, offsets: Array, from_arcs_m: Array, radius_m: float, cost_map: CostMap) -> Array:
    """Return how far to the left each follower keeps along the trail, shape (k, n) [m]: its slot's, less where there is no room.

    Nobody looks at the trail before `from_arcs_m`, shape (k,), where the followers begin.
    """
    lefts_m = np.zeros((len(offsets), len(trail.points_m)))
    for row, wanted_m, from_arc_m in zip(lefts_m, offsets[:, 1], from_arcs_m, strict=True):
        room_m = _room(trail, float(np.sign(wanted_m)), abs(wanted_m), radius_m, cost_map)
        first = int(np.clip(from_arc_m / STEP_M, 0, len(room_m) - 1))
        room_m[:first] = room_m[first]
        row[:] = np.sign(wanted_m) * _smoothly(room_m)
    return lefts_m


def blended(old: Array, new: Array, from_arc_m: float) -> Array:
    """Return `old`, shape (n,), up to an arc length, going over smoothly into `new`, shape (m,); where `old` ends it goes on as it was."""
    arcs_m = STEP_M * np.arange(len(new))
    share = np.clip((arcs_m - from_arc_m) / BLEND_M, 0.0, 1.0)
    weight = share**3 * (10.0 - 15.0 * share + 6.0 * share**2)  # no jump in slope or bend
    return np.asarray((1.0 - weight) * sample(old, arcs_m) + weight * new)


def _room(trail: Lane, sign: float, left_m: float, radius_m: float, cost_map: CostMap) -> Array:
    """Return how far to one side a body can go from the trail, up to `left_m`, shape (n,) [m]."""
    if left_m == 0.0:
        return np.zeros(len(trail.points_m))
    steps_m = np.linspace(0.0, left_m, round(left_m / LATERAL_STEP_M) + 2)
    places_m = trail.points_m[None] + sign * steps_m[:, None, None] * trail.normals()[None]
    fits = cost_map.clearance_m(places_m) >= radius_m + SIDE_MARGIN_M
    shortened = 1.0 - sign * steps_m[:, None] * trail.turns[None]
    open_steps = np.logical_and.accumulate(fits & (shortened >= LEAST_STRETCH), axis=0).sum(axis=0)
    return np.asarray(steps_m[np.maximum(open_steps - 1, 0)])


def _smoothly(room_m: Array) -> Array:
    """Return the room with no slope steeper than SLOPE and without corners, nowhere more than there is around."""
    climb_m = SLOPE * STEP_M * np.arange(len(room_m))
    reached_m = np.minimum.accumulate(room_m - climb_m) + climb_m
    both_m = np.minimum.accumulate((reached_m + climb_m)[::-1])[::-1] - climb_m
    half = round(0.5 * EASE_M / STEP_M)
    return averaged(minimum_filter1d(both_m, 4 * half + 1, mode="nearest"), half)


def averaged(rows: Array, half: int) -> Array:
    """Return the mean over +-half samples, taken twice, so that slopes are steady."""
    once = uniform_filter1d(rows, 2 * half + 1, mode="nearest")
    return np.asarray(uniform_filter1d(once, 2 * half + 1, mode="nearest"))
