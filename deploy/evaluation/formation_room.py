"""Where a formation would have had room to be whole, by the world's truth: its open slots, laid along the leader's true path, are clear."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import shapely

from deploy.evaluation.truth import Truth
from deploy.evaluation.tum import Trajectory
from protocol.geometry import Array

ROOM_BESIDE_M = 0.06  # between the body of a robot in its slot and whatever stands there
STILL_M = 5e-4  # what moves less between two stamps stands still
TANGENT_M = 0.05  # of the path, to either side, that gives its direction


class OpenSlots(NamedTuple):
    """Where the followers of a whole formation would have been at one stamp."""

    places_m: Array  # (k, 2) [arena]
    have_room: bool  # all of them


class Room:
    """Tells where every follower's open slot was, and whether there was room."""

    def __init__(self, truth: Truth, offsets: Array) -> None:
        """Take the world, and the slots (back, left), shape (k, 2) [m], of the whole formation."""
        self._offsets = offsets
        beside_m = max(truth.body_radius_m.values()) + ROOM_BESIDE_M
        things = shapely.union_all([obstacle.footprint.buffer(beside_m) for obstacle in truth.obstacles])
        self._free = truth.arena_bounds.buffer(-beside_m).difference(things)
        shapely.prepare(self._free)
        self._paths = {robot: _Path(trajectory) for robot, trajectory in truth.trajectories.items()}

    def slots(self, leader: str, stamp_ns: int) -> OpenSlots | None:
        """Return the open slots at a stamp; None before the leader has led along all of the formation's length."""
        places_m = self._paths[leader].beside(stamp_ns, self._offsets) if leader in self._paths else None
        return None if places_m is None else OpenSlots(places_m, bool(shapely.contains_xy(self._free, places_m).all()))


class _Path:
    """A robot's true path by its length."""

    def __init__(self, trajectory: Trajectory) -> None:
        points_m = trajectory.poses[:, :2]
        steps_m = np.hypot(*np.diff(points_m, axis=0).T)
        moved = np.concatenate([[True], steps_m > STILL_M])
        arcs_m = np.cumsum(np.concatenate([[0.0], np.where(moved[1:], steps_m, 0.0)]))
        self._arc_m: Mapping[int, float] = dict(zip(trajectory.stamps_ns.tolist(), arcs_m.tolist(), strict=True))
        self._arcs_m, self._points_m = arcs_m[moved], points_m[moved]

    def beside(self, stamp_ns: int, offsets: Array) -> Array | None:
        """Return the places, shape (k, 2) [m], so far (back, left) of where the robot was at a stamp; None where the path is too short."""
        arcs_m = self._arc_m.get(stamp_ns, 0.0) - offsets[:, 0]
        if arcs_m.min() < 0.0:
            return None
        ahead = self._at(arcs_m + TANGENT_M) - self._at(arcs_m - TANGENT_M)
        ahead /= np.maximum(np.hypot(*ahead.T), 1e-9)[:, None]
        return np.asarray(self._at(arcs_m) + offsets[:, 1:] * np.column_stack([-ahead[:, 1], ahead[:, 0]]))

    def _at(self, arcs_m: Array) -> Array:
        return np.column_stack([np.interp(arcs_m, self._arcs_m, self._points_m[:, axis]) for axis in (0, 1)])
