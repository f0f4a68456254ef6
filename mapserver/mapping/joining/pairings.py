"""Which points might be the same: of a seeker's own frame, and of the arena; each explains one sighting, if it is so.

What has been seen in one place is likely to be seen there again, whoever it is, and not far from there after a little while. So a later
sighting tells the more, the farther what it shows has moved.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mapserver.mapping.joining.moments import Moment, View
from mapserver.mapping.poses.association import sighted_point, sighting_covariance
from mapserver.mapping.poses.sighting_noise import BASE_CENTRE_SIGMA_M
from protocol.geometry import Array
from protocol.messages import Sighting

SIGHT_M2 = 10.0  # within such an area lies what a robot takes for another, when it is first seen
SCALE_SIGMA = 0.01  # of a range: how well cameras are known, by their height and tilt
DRIFT_SIGMA = 0.02  # of the way that a seeker has driven since a moment: its odometry


class Pairings(NamedTuple):
    """Pairs of points that may be the same, in the order of their slots: of a slot's pairs one at most is true."""

    start_m: Array  # (n, 2) [m; start]
    arena_m: Array  # (n, 2) [m; arena]
    sigma_m: Array  # (n,) of the distance between the two, on each axis
    slots: NDArray[np.intp]  # (n,) growing; one slot is one sighting of the seeker, or all of others that may show it
    moments: NDArray[np.intp]  # (n,)
    is_own: NDArray[np.bool_]  # (n,) the seeker's own place, seen by others; else what the seeker sees
    chance_m2: Array  # (n,) area within which the point would lie if it were another

    def __len__(self) -> int:
        """Return n."""
        return len(self.slots)


class _Pair(NamedTuple):
    start_m: Array
    arena_m: Array
    variance_m2: float
    is_own: bool


def pairings_of(seeker: str, moments: Sequence[Moment]) -> Pairings:
    """Return all pairs of points that could be the same."""
    rows: list[tuple[_Pair, int, int, float]] = []
    slot = 0
    ways_m = _ways_to_last(moments)
    for number, (moment, way_m) in enumerate(zip(moments, ways_m, strict=True)):
        for pairs in _slots(seeker, moment):
            rows += [(pair, slot, number, way_m) for pair in pairs]
            slot += bool(pairs)
    start_m = np.array([pair.start_m for pair, *_ in rows]).reshape(-1, 2)
    at = np.array([number for _, _, number, _ in rows], dtype=np.intp)
    is_own = np.array([pair.is_own for pair, *_ in rows], dtype=np.bool_)
    return Pairings(
        start_m=start_m,
        arena_m=np.array([pair.arena_m for pair, *_ in rows]).reshape(-1, 2),
        sigma_m=np.array([math.sqrt(pair.variance_m2 + (DRIFT_SIGMA * way_m) ** 2) for pair, _, _, way_m in rows]),
        slots=np.array([number for _, number, _, _ in rows], dtype=np.intp),
        moments=at,
        is_own=is_own,
        chance_m2=_chance_m2(start_m, at, is_own),
    )


def is_of(sighting: Sighting, robot: str) -> bool:
    """Tell whether a sighting may show a robot: it names it, or nobody."""
    return sighting.identity.kind == "none" or (sighting.identity.kind == "robot" and sighting.identity.name == robot)


def _chance_m2(start_m: Array, moments: NDArray[np.intp], is_own: NDArray[np.bool_]) -> Array:
    """Return the area, (n,), of a disc around each point that reaches to the nearest of its kind of an earlier moment."""
    gaps_m = np.hypot(*(start_m[:, None] - start_m[None]).T).T
    is_later = (moments[:, None] > moments[None]) & (is_own[:, None] == is_own[None])
    nearest_m = np.where(is_later, gaps_m, np.inf).min(axis=1, initial=np.inf)
    return np.asarray(np.minimum(math.pi * nearest_m**2, SIGHT_M2))


def _ways_to_last(moments: Sequence[Moment]) -> list[float]:
    """Return how far the seeker has driven from each moment to the last [m]."""
    steps_m = [math.dist(a.start_from_body[:2], b.start_from_body[:2]) for a, b in pairwise(moments)]
    return [sum(steps_m[number:]) for number in range(len(moments))]


def _slots(seeker: str, moment: Moment) -> Iterator[list[_Pair]]:
    """Yield the pairs of each slot: whoever sees the seeker, all see the same; what the seeker sees are different things."""
    yield [
        _Pair(np.array(view.start_from_seeker[:2]), _arena_point(view, stranger), _variance_m2(stranger), is_own=True)
        for view in moment.views
        for stranger in view.strangers
        if is_of(stranger, seeker)
    ]
    for sighting in moment.local_map.sightings:
        yield list(_shown(sighting, moment))


def _shown(sighting: Sighting, moment: Moment) -> Iterator[_Pair]:
    """Yield whom a sighting of the seeker may show: a robot that has a place, or a stranger whom such a robot sees too."""
    start_m = moment.start_from_body.apply(sighted_point(sighting))
    for robot, pose in moment.robots.items():
        if is_of(sighting, robot):
            yield _Pair(start_m, np.array(pose[:2]), _variance_m2(sighting), is_own=False)
    for view in moment.views if sighting.identity.kind == "none" else ():
        for stranger in view.strangers:
            yield _Pair(start_m, _arena_point(view, stranger), _variance_m2(sighting) + _variance_m2(stranger), is_own=False)


def _arena_point(view: View, sighting: Sighting) -> Array:
    return view.arena_from_body.apply(sighted_point(sighting))


def _variance_m2(sighting: Sighting) -> float:
    """Return the variance of a sighted point on each axis: as stated, of the base's fit, and of the camera."""
    stated = np.diag(sighting_covariance(sighting)) * (1.0, sighting.range_m**2)
    return float(stated.max()) + BASE_CENTRE_SIGMA_M**2 + (SCALE_SIGMA * sighting.range_m) ** 2
