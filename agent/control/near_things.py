"""What stands near the robot: the newest local map, and what has slid under the robot's own shadow since it was last seen.

The own body hides the floor around it, up to more than twice its radius. So whatever comes nearer than that is known only from the pictures
before, and has to be remembered, moved along by odometry, for as long as it is hidden.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from agent.control.bare_floor import BareFloor
from agent.control.borders import NEAR_M, SPACING_M, Borders, body_borders, norms, seen_borders, within
from agent.control.persistence import Persistence
from agent.control.trodden import Trodden
from protocol.geometry import Array, Pose2
from protocol.messages import LocalMap

THING_S, DOUBTFUL_S, ROBOT_S = 120.0, 2.0, 0.5  # how long something hidden is remembered; the second, where probably nothing stands
ONE_THING_M = 0.05  # what stands so near to something hidden is remembered with it, though it shows no more: its side may be like the floor
GOES_ON_RAD, GOES_ON_M = 0.5, 0.02  # something hidden goes on where something is seen in its direction, so near to what is hidden
HIDDEN_M = 0.01  # behind the edge of what the own body hides: farther in, an outline is only guessed
UNDER_SHARE = 0.5  # of the own body's radius: nothing stands so near to its middle
AT_REST_S = 1.0  # what has moved is taken to move for so long after that
LOCATED_S = 0.5  # for so long a robot is taken to be where the map server last saw it


class KnownBorders(NamedTuple):
    """Border points in the odometry's frame, and when each was last seen."""

    points_m: Array  # (n, 2) [odom]
    moving: NDArray[np.bool_]  # (n,)
    on_robot: NDArray[np.bool_]  # (n,)
    seen_ns: NDArray[np.int64]  # (n,)
    on_bare_floor: NDArray[np.bool_]  # (n,) for most pictures, of what is hidden

    def select(self, rows: NDArray[Any]) -> KnownBorders:
        """Return some of the points, by mask or index."""
        return KnownBorders(*(part[rows] for part in self))

    def joined(self, other: KnownBorders) -> KnownBorders:
        """Return the points of both."""
        return KnownBorders(*(np.concatenate(pair) for pair in zip(self, other, strict=True)))

    def until_ns(self) -> Array:
        """Return until when each is remembered once it is hidden, (n,): also what moves, since it may only have seemed to."""
        return np.asarray(self.seen_ns + 1e9 * np.where(self.on_robot, ROBOT_S, THING_S))


_NONE = np.empty(0, dtype=np.bool_)
_NOTHING = KnownBorders(np.empty((0, 2)), _NONE, _NONE, np.empty(0, dtype=np.int64), _NONE)


class NearThings:
    """Remembers the borders of the things around one robot."""

    def __init__(self, body_radius_m: float) -> None:
        self._radius_m = body_radius_m
        self._known = _NOTHING
        self._persistence = Persistence()
        self._trodden = Trodden(body_radius_m)
        self._bare_floor = BareFloor(body_radius_m)
        self._used_ns = -1  # the stamp of the last picture that was used
        self._moved_ns: dict[int, int] = {}  # by label, when a thing last moved
        self._located_ns, self._robots_m = 0, np.empty((0, 2))  # when the map server last told, and where other robots were [odom]

    def see(self, local_map: LocalMap) -> None:
        """Take a local map; what it could not see stays as it was, all of it where its picture was dropped."""
        odom_from_body = Pose2(*local_map.odom_from_body)
        if local_map.picture == "used":
            seen = self._lasting(local_map, odom_from_body)
            self._bare_floor.note(local_map)
            hidden = self._hidden(seen, odom_from_body, local_map.body_radius_m, local_map.stamp_ns)
            self._known = seen.joined(thinned(hidden))
            self._used_ns = local_map.stamp_ns

    def note_robots(self, stamp_ns: int, robot: str, centres_m: dict[str, Array]) -> None:
        """Take where robots are, by name, (2,) [odom] each, among them `robot` itself: nothing stands where they have been."""
        self._trodden.note(stamp_ns, centres_m)
        others = [centre_m for other, centre_m in centres_m.items() if other != robot]
        self._located_ns, self._robots_m = stamp_ns, np.array(others).reshape(-1, 2)

    def around(self, odom_from_body: Pose2, since_ns: int = 0) -> Borders:
        """Return the borders [body] around the robot where it now is, as far as they were seen at a stamp or since."""
        points = odom_from_body.inverse().apply(self._known.points_m)
        near = (norms(points) < NEAR_M) & (self._known.seen_ns >= since_ns)
        return Borders(points[near], self._known.moving[near])

    def robots(self, odom_from_body: Pose2) -> Borders:
        """Return the borders [body] of the other robots where the map server last saw them."""
        return body_borders(odom_from_body.inverse().apply(self._robots_m), self._radius_m)

    def _robots_at(self, stamp_ns: int) -> Array:
        """Return where other robots are, (k, 2) [odom]; nowhere, if that was told too long ago."""
        return self._robots_m if stamp_ns - self._located_ns <= 1e9 * LOCATED_S else self._robots_m[:0]

    def _lasting(self, local_map: LocalMap, odom_from_body: Pose2) -> KnownBorders:
        """Return what a local map shows and does not only flicker."""
        robots_m = odom_from_body.inverse().apply(self._robots_at(local_map.stamp_ns))
        borders = seen_borders(local_map, robots_m, self._radius_m)
        moving = borders.moving | self._moved_just_now(local_map, borders.labels)
        stamps_ns = np.full(len(moving), local_map.stamp_ns)
        unweighed = np.zeros(len(moving), dtype=np.bool_)
        seen = KnownBorders(odom_from_body.apply(borders.points_m), moving, borders.on_robot, stamps_ns, unweighed)
        is_hidden = norms(borders.points_m) < local_map.body_radius_m - HIDDEN_M
        return seen.select(self._persistence.lasting(seen.points_m, borders.labels, is_hidden))

    def _moved_just_now(self, local_map: LocalMap, labels: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Tell of which border points the things, by their labels, (n,), move, or did lately; a robot beside a thing does not move it."""
        stamp_ns = local_map.stamp_ns
        self._moved_ns = {label: moved_ns for label, moved_ns in self._moved_ns.items() if stamp_ns - moved_ns <= 1e9 * AT_REST_S}
        self._moved_ns |= {region.label: stamp_ns for region in local_map.regions if region.motion == "moving"}
        return np.isin(labels, list(self._moved_ns))

    def _hidden(self, seen: KnownBorders, odom_from_body: Pose2, hidden_range_m: float, stamp_ns: int) -> KnownBorders:
        """Return what is known and cannot be seen from here, and is not too old."""
        known = self._known.select(stamp_ns <= self._known.until_ns())
        known = known._replace(
            moving=known.moving & (stamp_ns - known.seen_ns <= 1e9 * AT_REST_S)
        )  # later nothing tells that it still does
        body_from_odom = odom_from_body.inverse()
        ranges_m = norms(body_from_odom.apply(known.points_m))
        is_outside = ranges_m > UNDER_SHARE * self._radius_m
        known, is_hidden = known.select(is_outside), ranges_m[is_outside] < hidden_range_m
        known = known.select(is_hidden | (~known.moving & within(known.points_m, known.points_m[is_hidden & ~known.moving], ONE_THING_M)))
        known = self._weighed(known)
        is_old = stamp_ns - known.seen_ns > 1e9 * DOUBTFUL_S
        return known.select(~(is_old & self._is_doubtful(known, seen, body_from_odom, hidden_range_m))) if is_old.any() else known

    def _weighed(self, known: KnownBorders) -> KnownBorders:
        """Return what is hidden, and of what still showed in the last picture, whether that is bare floor for most pictures."""
        last = np.flatnonzero(known.seen_ns == self._used_ns)
        on_bare_floor = known.on_bare_floor.copy()
        on_bare_floor[last] = self._bare_floor.mostly(known.points_m[last])
        return known._replace(on_bare_floor=on_bare_floor)

    def _is_doubtful(self, known: KnownBorders, seen: KnownBorders, body_from_odom: Pose2, hidden_range_m: float) -> NDArray[np.bool_]:
        """Tell which hidden points, (n,), lie on bare floor or where a robot has been, with nothing seen right behind but more of that."""
        beside = seen.select(norms(body_from_odom.apply(seen.points_m)) < hidden_range_m + GOES_ON_M)
        others = beside.select(~self._trodden.holds(beside.points_m))
        goes_on = _go_on(body_from_odom.apply(known.points_m), body_from_odom.apply(others.points_m))
        return (known.on_bare_floor | self._trodden.holds(known.points_m)) & ~goes_on


def _go_on(hidden_m: Array, seen_m: Array) -> NDArray[np.bool_]:
    """Tell which hidden points, (n, 2) [body], may belong to something that is seen right behind them, at (m, 2) [body]."""
    towards, others = (points / norms(points)[:, None] for points in (hidden_m, seen_m))
    return np.asarray((towards @ others.T > math.cos(GOES_ON_RAD)).any(axis=1))


def thinned(known: KnownBorders) -> KnownBorders:
    """Return of each square of SPACING_M the point that is remembered longest, so that none is remembered twice."""
    longest_first = known.select(np.argsort(-known.until_ns(), kind="stable"))
    cells = np.floor(longest_first.points_m / SPACING_M).astype(np.int64)
    _, first = np.unique(cells[:, 0] * 2**32 + cells[:, 1], return_index=True)
    return longest_first.select(np.sort(first))
