"""Who takes which slot: the assignment of least total distance, in which no two straight ways cross."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.optimize import linear_sum_assignment

from protocol.geometry import Array, Pose2


def assign(robots: Mapping[str, Pose2], slots_m: Array) -> tuple[str, ...]:
    """Return the robot for every slot, (n, 2) [m; arena], for as many robots as slots.

    Two ways that cross could be exchanged for two that do not and are shorter together, so the shortest assignment has no crossing.
    """
    names = sorted(robots)
    places_m = np.array([robots[name][:2] for name in names]).reshape(-1, 2)
    _, chosen = linear_sum_assignment(_distances_m(slots_m, places_m))
    return tuple(names[number] for number in chosen)


def total_distance_m(places_m: Array, slots_m: Array) -> float:
    """Return how far robots at places, shape (n, 2), have to go in all to as many slots, shape (n, 2)."""
    distances_m = _distances_m(slots_m, places_m)
    return float(distances_m[linear_sum_assignment(distances_m)].sum())


def _distances_m(slots_m: Array, places_m: Array) -> Array:
    return np.asarray(np.hypot(*(slots_m[:, None] - places_m[None]).transpose(2, 0, 1)))
