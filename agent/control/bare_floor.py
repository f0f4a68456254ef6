"""Where bare floor showed lately: what seemed to stand there is a mark on it, or a shadow, for all that most pictures tell."""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from agent.control.borders import norms, sighted_m, within
from protocol.geometry import Array, Pose2
from protocol.messages import LocalMap

VIEWS = 10  # local maps that are remembered
LEAST_VIEWS = 4  # of a place, for them to tell anything
MOST_RANGE_M = 0.45  # of a place: from farther off a mark looks as much like a thing as from near, and a thing as much like floor
BEYOND_M = 0.01  # behind a border: on it the same picture shows either


class _View(NamedTuple):
    """One local map: its outlines, side by side, and the robots in it."""

    body_from_odom: Pose2
    hidden_range_m: float
    starts_m: Array  # (e, 2) [body]
    ends_m: Array  # (e, 2) [body]
    firsts: NDArray[np.intp]  # of each outline, its first side
    robots_m: Array  # (k, 2) [body]


class BareFloor:
    """Remembers the last few local maps of one robot."""

    def __init__(self, body_radius_m: float) -> None:
        self._radius_m = body_radius_m
        self._views: deque[_View] = deque(maxlen=VIEWS)

    def note(self, local_map: LocalMap) -> None:
        """Take what a local map shows."""
        outlines_m = [region.outline.metres() for region in local_map.regions]
        outlines_m = [outline_m for outline_m in outlines_m if norms(outline_m).min() < MOST_RANGE_M + BEYOND_M]
        ends_m = [np.roll(outline_m, -1, axis=0) for outline_m in outlines_m]
        self._views.append(
            _View(
                Pose2(*local_map.odom_from_body).inverse(),
                local_map.body_radius_m,
                np.concatenate([np.empty((0, 2)), *outlines_m]),
                np.concatenate([np.empty((0, 2)), *ends_m]),
                np.cumsum([0, *map(len, outlines_m)])[:-1],
                sighted_m(local_map),
            )
        )

    def mostly(self, points_m: Array) -> NDArray[np.bool_]:
        """Tell at which of some borders, (n, 2) [odom], most of the maps in which they were in view show bare floor."""
        in_view, bare = np.zeros((2, len(points_m)), dtype=np.int64)
        for view in self._views:
            points = view.body_from_odom.apply(points_m)
            ranges_m = norms(points)
            is_near = (ranges_m > view.hidden_range_m) & (ranges_m < MOST_RANGE_M)
            beyond = points * (1.0 + BEYOND_M / np.maximum(ranges_m, BEYOND_M))[:, None]
            in_view += is_near
            bare += is_near & ~_inside(beyond, view) & ~within(beyond, view.robots_m, self._radius_m + BEYOND_M)
        return np.asarray((in_view >= LEAST_VIEWS) & (2 * bare > in_view))


def _inside(points_m: Array, view: _View) -> NDArray[np.bool_]:
    """Tell which points, (n, 2), lie within any outline of a view: a ray from there crosses its sides an odd number of times."""
    if not len(view.firsts):
        return np.zeros(len(points_m), dtype=np.bool_)
    (x1, y1), (x2, y2) = view.starts_m.T, view.ends_m.T
    x, y = points_m.T[:, :, None]
    spans = (y1 > y) != (y2 > y)
    with np.errstate(divide="ignore", invalid="ignore"):
        crosses = spans & (x < x1 + (y - y1) * (x2 - x1) / (y2 - y1))
    return np.asarray((np.add.reduceat(crosses, view.firsts, axis=1, dtype=np.int64) % 2 == 1).any(axis=1))
