"""How a formation gives way: followers draw in to the trail where it is narrow, and those that would meet there fall in one behind another.

Both are smooth functions of arc length, so that a follower draws in before it reaches the narrow place, and opens once it is through.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.ndimage import maximum_filter1d, minimum_filter1d, uniform_filter1d

from mapserver.formation.costmap import CostMap
from mapserver.formation.trail import STEP_M, Lane, sample
from protocol.geometry import Array

LATERAL_STEP_M = 0.02
SIDE_MARGIN_M = 0.045  # between a follower's body and things beside the trail
LEAST_STRETCH = 0.4  # on the inside of a bend no lane gets shorter than this share of the trail
RAMP_PER_LEFT = 1.25  # a follower takes twice so many metres of trail for a metre to the side
LEAST_RAMP_M = 0.15
RAMP_PER_BACK = 1.3  # and for a metre to fall back
BLEND_M = 0.45  # of trail, over which a new plan takes over from the old one
FALL_IN_STEPS = 4  # from slot to column
ROUNDS = 8  # of finding out where followers would meet


class Spacing(NamedTuple):
    """How near robots' centres may come to each other [m]: in a column they follow at `column_m`, and nobody comes below `least_m`."""

    column_m: float
    least_m: float

    @classmethod
    def of(cls, radius_m: float) -> Spacing:
        """Return the spacing of bodies with this radius."""
        return cls(2.0 * radius_m + 0.17, 2.0 * radius_m + 0.135)


def column_backs(backs_m: Array, spacing_m: float) -> Array:
    """Return the backs of a column, shape (k,) [m], in the same order, as near as can be to given ones, which ascend.

    With a = back - number * spacing this is isotonic regression in the maximum norm, half way between running maximum and minimum.
    """
    ranks_m = spacing_m * np.arange(1, len(backs_m) + 1)
    ahead_m = backs_m - ranks_m
    upper_m = np.maximum.accumulate(ahead_m)
    lower_m = np.minimum.accumulate(ahead_m[::-1])[::-1]
    return np.asarray(np.maximum(0.5 * (upper_m + lower_m), 0.0) + ranks_m)


def lefts_along(trail: Lane, offsets: Array, from_arcs_m: Array, radius_m: float, cost_map: CostMap) -> Array:
    """Return how far to the left each follower keeps along the trail, shape (k, n) [m]: its slot's, less where there is no room.

    Nobody looks at the trail before `from_arcs_m`, shape (k,), where the followers begin.
    """
    lefts_m = np.zeros((len(offsets), len(trail.points_m)))
    for row, wanted_m, from_arc_m in zip(lefts_m, offsets[:, 1], from_arcs_m, strict=True):
        room_m = _room(trail, float(np.sign(wanted_m)), abs(wanted_m), radius_m, cost_map)
        first = int(np.clip(from_arc_m / STEP_M, 0, len(room_m) - 1))
        room_m[:first] = room_m[first]
        row[:] = np.sign(wanted_m) * _smoothly(room_m, abs(wanted_m))
    return lefts_m


def backs_along(lanes: Sequence[Lane], offsets: Array, from_arc_m: float, spacing: Spacing) -> Array:
    """Return how far behind the leader each follower keeps, for every arc length of the leader, shape (k, n) [m].

    The slot's where that keeps all apart, the column's where followers would meet; `lanes` are the leader's and the followers', in order.
    Nobody looks at what would be with the leader before `from_arc_m`.
    """
    count = len(lanes[0].points_m)
    if len(offsets) == 0:
        return np.zeros((0, count))
    open_m = offsets[:, 0]
    change_m = column_backs(open_m, spacing.column_m) - open_m
    ramp = _samples(max(RAMP_PER_BACK * float(np.abs(change_m).max()), LEAST_RAMP_M))
    first = int(from_arc_m / STEP_M)
    fallen_in = np.zeros(count)  # share of the change from slot to column
    for _ in range(ROUNDS):
        backs_m = open_m[:, None] + change_m[:, None] * _ramped(fallen_in, ramp)
        too_near = closest_along(lanes, backs_m) < spacing.least_m
        too_near[:first] = False
        if not (too_near & (fallen_in < 1.0)).any():
            break
        fallen_in = np.minimum(fallen_in + too_near / FALL_IN_STEPS, 1.0)
    return backs_m


def closest_along(lanes: Sequence[Lane], backs_m: Array) -> Array:
    """Return the least distance between any two robots for every arc length of the leader, shape (n,) [m]."""
    arcs_m = STEP_M * np.arange(len(lanes[0].points_m)) - np.vstack([np.zeros((1, backs_m.shape[1])), backs_m])
    places_m = np.array([sample(lane.points_m, arc_m) for lane, arc_m in zip(lanes, arcs_m, strict=True)])
    closest = np.full(backs_m.shape[1], np.inf)
    for first in range(len(places_m)):
        for second in range(first + 1, len(places_m)):
            closest = np.minimum(closest, np.hypot(*(places_m[first] - places_m[second]).T))
    return closest


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


def _smoothly(room_m: Array, most_m: float) -> Array:
    """Return the room without steps and corners, nowhere more than there is around."""
    half = _samples(max(RAMP_PER_LEFT * most_m, LEAST_RAMP_M) / 2.0)
    return _averaged(minimum_filter1d(room_m, 4 * half + 1, mode="nearest"), half)


def _ramped(needed: Array, half: int) -> Array:
    """Return at least as much as is needed everywhere, with smooth ramps around."""
    return _averaged(maximum_filter1d(needed, 2 * half + 1, mode="nearest"), half // 2)


def _averaged(rows: Array, half: int) -> Array:
    """Return the mean over +-half samples, taken twice, so that slopes are steady."""
    once = uniform_filter1d(rows, 2 * half + 1, mode="nearest")
    return np.asarray(uniform_filter1d(once, 2 * half + 1, mode="nearest"))


def _samples(length_m: float) -> int:
    return max(round(length_m / STEP_M), 2)
