"""How followers fall in one behind another where they would meet, and catch up again.

Followers are planned one after the other, each against all that go before it. Over the leader's arc length s and the follower's own, the
places where it would come too near to somebody are forbidden regions; it passes below them, later than the others (Kant and Zucker,
"Toward efficient trajectory planning: the path-velocity decomposition", IJRR 1986).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mapserver.formation.narrowing import averaged
from mapserver.formation.trail import STEP_M, Lane, sample
from protocol.geometry import Array

BACK_STEP_M = 0.02  # between the distances behind the leader that are tried
SPARE_BACK_M = 0.8  # farther back than in its column a follower may fall
FASTEST_PACE = 2.0  # metres of the trail for one of the leader's, of a follower that catches up
EASE_STEPS = 6  # half the length over which paces change
BLEND_M = 0.20  # of trail, over which a new plan takes over
ROUNDS = 4  # of finding a way past all forbidden regions


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


def backs_along(lanes: Sequence[Lane], open_m: Array, from_arc_m: float, spacing: Spacing, held_m: Array | None = None) -> Array:
    """Return how far behind the leader each follower keeps, for every arc length of the leader, shape (k, n) [m].

    That is its slot's `open_m`, shape (k,), where that keeps all apart, and else as much more as it needs; `lanes` are the leader's and the
    followers', in the order of a column. Nobody looks at what would be with the leader before `from_arc_m`, up to where `held_m`,
    shape (k, any), is kept to, if it is given.
    """
    places_m = [lanes[0].points_m]
    backs_m = np.zeros((len(open_m), len(places_m[0])))
    first = int(np.clip(from_arc_m / STEP_M, 0, len(places_m[0]) - 1))
    for number, lane in enumerate(lanes[1:]):
        tried_m = open_m[number] + np.arange(0.0, spacing.column_m * (number + 1) + SPARE_BACK_M, BACK_STEP_M)
        is_near = _near(lane, tried_m, places_m, spacing.column_m)
        is_near[:, :first] = False
        if held_m is None:
            backs_m[number] = _past(is_near, tried_m, first, None)
        else:
            now_m = float(sample(held_m[number], from_arc_m))
            backs_m[number] = _taken_over(held_m[number], _past(is_near, tried_m, first, now_m), from_arc_m)
        places_m.append(_places(lane, backs_m[number]))
    return backs_m


def closest_along(lanes: Sequence[Lane], backs_m: Array) -> Array:
    """Return the least distance between any two robots for every arc length of the leader, shape (n,) [m]."""
    places_m = [lanes[0].points_m, *(_places(lane, back_m) for lane, back_m in zip(lanes[1:], backs_m, strict=True))]
    closest = np.full(backs_m.shape[1], np.inf)
    for first in range(len(places_m)):
        for second in range(first + 1, len(places_m)):
            closest = np.minimum(closest, np.hypot(*(places_m[first] - places_m[second]).T))
    return closest


def _places(lane: Lane, back_m: Array) -> Array:
    return sample(lane.points_m, STEP_M * np.arange(len(back_m)) - back_m)


def _near(lane: Lane, tried_m: Array, others_m: Sequence[Array], apart_m: float) -> NDArray[np.bool_]:
    """Tell for each back that is tried, and each arc length of the leader, whether that is too near to anybody, shape (tried, n)."""
    arcs_m = STEP_M * np.arange(len(others_m[0]))
    places_m = sample(lane.points_m, arcs_m[None] - tried_m[:, None])
    is_near = np.zeros(places_m.shape[:2], dtype=np.bool_)
    for other_m in others_m:
        off_m = places_m - other_m[None]
        is_near |= off_m[..., 0] ** 2 + off_m[..., 1] ** 2 < apart_m**2
    return is_near


def _past(is_near: NDArray[np.bool_], tried_m: Array, first: int, now_m: float | None) -> Array:
    """Return the backs, shape (n,) [m], of somebody who keeps as far ahead as it can below all that is forbidden."""
    columns = np.arange(is_near.shape[1])
    chosen = np.zeros(len(columns), dtype=np.int64)
    for _ in range(ROUNDS):
        chosen = _next_free(is_near, chosen)
        back_m = _gentle(tried_m[chosen], first, now_m)
        held = np.clip(np.rint((back_m - tried_m[0]) / BACK_STEP_M).astype(np.int64), 0, len(tried_m) - 1)
        hits = is_near[held, columns] & (held > chosen)
        if not hits.any():
            break
        chosen = np.where(hits, held, chosen)
    return back_m


def _next_free(is_near: NDArray[np.bool_], chosen: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return for each column the first row from the chosen one on that is free, the last one where none is."""
    rows = np.arange(len(is_near))[:, None]
    usable = ~is_near & (rows >= chosen)
    return np.where(usable.any(axis=0), usable.argmax(axis=0), len(is_near) - 1)


def _gentle(needed_m: Array, first: int, now_m: float | None) -> Array:
    """Return backs that are nowhere much less than needed, for somebody who never goes back and does not rush."""
    arcs_m = STEP_M * np.arange(len(needed_m))
    own_m = arcs_m - needed_m
    own_m[first:] = np.minimum.accumulate(own_m[first:][::-1])[::-1]  # what it has to wait for, it awaits where it is
    start_m = own_m[first] if now_m is None else arcs_m[first] - now_m
    own_m[: first + 1] = start_m + arcs_m[: first + 1] - arcs_m[first]
    own_m[first:] = np.maximum(own_m[first:], start_m)
    steady_m = np.minimum.accumulate(own_m - FASTEST_PACE * arcs_m) + FASTEST_PACE * arcs_m
    return np.asarray(arcs_m - _eased(np.asarray(steady_m)))


def _eased(own_m: Array) -> Array:
    """Return the mean over +-EASE_STEPS, taken twice, of a way that goes on evenly at both ends."""
    margin = 2 * EASE_STEPS
    before_m = own_m[0] - STEP_M * np.arange(margin, 0, -1)
    after_m = own_m[-1] + STEP_M * np.arange(1, margin + 1)
    return averaged(np.concatenate([before_m, own_m, after_m]), EASE_STEPS)[margin:-margin]


def _taken_over(old_m: Array, new_m: Array, from_arc_m: float) -> Array:
    """Return backs that go over from an old row, shape (n,), into a new one, shape (m,), without a step back."""
    arcs_m = STEP_M * np.arange(len(new_m))
    share = np.clip((arcs_m - from_arc_m) / BLEND_M, 0.0, 1.0)
    own_m = arcs_m - (1.0 - share) * sample(old_m, arcs_m) - share * new_m
    return np.asarray(arcs_m - np.maximum.accumulate(own_m))
