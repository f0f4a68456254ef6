"""What stands near the robot: the newest local map, and what has slid under the robot's own shadow since it was last seen.

The own body hides the floor around it, up to more than twice its radius. So whatever comes nearer than that is known only from the pictures
before, and has to be remembered, moved along by odometry, for as long as it is hidden.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from agent.control.borders import NEAR_M, SPACING_M, Borders, norms, seen_borders
from agent.control.persistence import Persistence
from protocol.geometry import Array, Pose2
from protocol.messages import LocalMap

STATIC_S, MOVING_S = 20.0, 0.5  # how long something hidden is remembered


class KnownBorders(NamedTuple):
    """Border points in the odometry's frame, and when each was last seen."""

    points_m: Array  # (n, 2) [odom]
    moving: NDArray[np.bool_]  # (n,)
    seen_ns: NDArray[np.int64]  # (n,)

    def select(self, rows: NDArray[Any]) -> KnownBorders:
        """Return some of the points, by mask or index."""
        return KnownBorders(self.points_m[rows], self.moving[rows], self.seen_ns[rows])

    def joined(self, other: KnownBorders) -> KnownBorders:
        """Return the points of both."""
        points_m = np.concatenate([self.points_m, other.points_m])
        return KnownBorders(points_m, np.concatenate([self.moving, other.moving]), np.concatenate([self.seen_ns, other.seen_ns]))


_NOTHING = KnownBorders(np.empty((0, 2)), np.empty(0, dtype=np.bool_), np.empty(0, dtype=np.int64))


class NearThings:
    """Remembers the borders of the things around one robot."""

    def __init__(self, body_radius_m: float) -> None:
        self._radius_m = body_radius_m
        self._known = _NOTHING
        self._persistence = Persistence()

    def see(self, local_map: LocalMap) -> None:
        """Take a local map; what it could not see stays as it was, all of it where its picture was dropped."""
        odom_from_body = Pose2(*local_map.odom_from_body)
        if local_map.picture == "used":
            points, moving, labels = seen_borders(local_map, self._radius_m)
            seen = KnownBorders(odom_from_body.apply(points), moving, np.full(len(points), local_map.stamp_ns))
            lasting = seen.select(self._persistence.lasting(seen.points_m, labels))
            hidden = self._hidden(odom_from_body, local_map.body_radius_m, local_map.stamp_ns)
            self._known = lasting.joined(thinned(hidden))  # newest first

    def around(self, odom_from_body: Pose2) -> Borders:
        """Return the borders [body] around the robot where it now is."""
        points = odom_from_body.inverse().apply(self._known.points_m)
        near = norms(points) < NEAR_M
        return Borders(points[near], self._known.moving[near])

    def _hidden(self, odom_from_body: Pose2, hidden_range_m: float, stamp_ns: int) -> KnownBorders:
        """Return what is known and cannot be seen from here, and is not too old."""
        ranges = norms(odom_from_body.inverse().apply(self._known.points_m))
        limits_ns = np.where(self._known.moving, 1e9 * MOVING_S, 1e9 * STATIC_S)
        return self._known.select((ranges < hidden_range_m) & (stamp_ns - self._known.seen_ns <= limits_ns))


def thinned(known: KnownBorders) -> KnownBorders:
    """Return the first point of each square of SPACING_M, so that no place is remembered twice."""
    cells = np.floor(known.points_m / SPACING_M).astype(np.int64)
    _, first = np.unique(cells[:, 0] * 2**32 + cells[:, 1], return_index=True)
    return known.select(np.sort(first))
