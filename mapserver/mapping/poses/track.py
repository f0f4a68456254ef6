"""One robot's path in the pose graph: its variables in the order of their stamps, the newest belief, and what became of the older ones."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mapserver.mapping.belief import Belief, Twist
from protocol.geometry import Array, Pose2
from protocol.messages import LocalMap

START_SIGMA = 1e-4  # [m or rad]: what a configured sigma of 0 means
FOUND_SIGMA = np.array([0.02, 0.02, 0.05])  # a robot whose place is known so well need not be searched for [m, m, rad; body]
SEARCH_NS = 5_000_000_000  # nobody is searched for longer: where nobody sees it, its last pose is the best there is
MOST_PAST_POSES = 20_000  # of a robot that are remembered though they have left the graph; beyond, every second is forgotten
_KEYS_PER_ROBOT_BITS = 40


@dataclass(frozen=True)
class Start:
    """Where a robot is set down: pose in the arena and its standard deviations, shape (3,) [m, m, rad; arena]."""

    arena_from_body: Pose2
    sigma: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def belief(self) -> Belief:
        """Return the pose with its covariance turned into the body frame."""
        body_from_arena = np.eye(3)
        body_from_arena[:2, :2] = self.arena_from_body.rotation().T
        variances = np.maximum(self.sigma, START_SIGMA) ** 2
        return Belief(self.arena_from_body, body_from_arena @ np.diag(variances) @ body_from_arena.T, predicted=True)


@dataclass
class Past:
    """The poses of a path that have left the graph, at their last estimates; the longer the path, the fewer of each second."""

    stamps_ns: list[int] = field(default_factory=list)
    poses: list[Pose2] = field(default_factory=list)

    def add(self, stamp_ns: int, arena_from_body: Pose2) -> None:
        """Remember a pose newer than all others."""
        self.stamps_ns.append(stamp_ns)
        self.poses.append(arena_from_body)
        if len(self.stamps_ns) > MOST_PAST_POSES:
            del self.stamps_ns[1::2], self.poses[1::2]

    def pose(self, stamp_ns: int) -> Pose2 | None:
        """Return the pose of exactly this stamp, if it is remembered."""
        number = _number_of(self.stamps_ns, stamp_ns)
        return None if number is None else self.poses[number]


@dataclass
class Track:
    """One robot's path: the stamps of its variables, which are numbered through, and the newest belief."""

    index: int  # of the robot
    belief: Belief
    stamps_ns: list[int] = field(default_factory=list)  # of the variables that are in the graph
    past: Past = field(default_factory=Past)
    last: LocalMap | None = None
    twist: Twist | None = None
    searched_ns: int | None = None  # since when it is searched for
    _left: int = 0  # variables that have left the graph

    def key(self, number: int) -> int:
        """Return the key of one of the variables in the graph, the oldest of them being number 0."""
        return (self.index << _KEYS_PER_ROBOT_BITS) + self._left + number

    def key_at(self, stamp_ns: int) -> int | None:
        """Return the key of the variable of exactly this stamp, if it is in the graph."""
        number = _number_of(self.stamps_ns, stamp_ns)
        return None if number is None else self.key(number)

    def newest_key(self) -> int:
        """Return the key of the newest variable."""
        return self.key(len(self.stamps_ns) - 1)

    def leave(self, count: int, pose: Callable[[int], Pose2]) -> list[int]:
        """Let the oldest variables leave the graph, their poses, by key, as they are now; return their keys."""
        keys = [self.key(number) for number in range(count)]
        for stamp_ns, key in zip(self.stamps_ns, keys, strict=False):
            self.past.add(stamp_ns, pose(key))
        del self.stamps_ns[:count]
        self._left += count
        return keys

    def trajectory(self, pose: Callable[[int], Pose2]) -> tuple[NDArray[np.int64], Array]:
        """Return the whole path, by the poses of keys: stamps, shape (n,) [ns], and poses, shape (n, 3) [m, m, rad; arena]."""
        poses = [*self.past.poses, *(pose(self.key(number)) for number in range(len(self.stamps_ns)))]
        stamps_ns = np.array([*self.past.stamps_ns, *self.stamps_ns], dtype=np.int64)
        return stamps_ns, np.array(poses, dtype=np.float64).reshape(-1, 3)

    def end_search(self) -> None:
        """Search no longer where the place is well known, or where nobody has told it for long."""
        if self.searched_ns is not None and (self.is_well_known() or self.stamps_ns[-1] - self.searched_ns > SEARCH_NS):
            self.searched_ns = None

    def is_well_known(self) -> bool:
        """Tell whether the newest pose is known so well that the robot need not be searched for."""
        return bool((np.diag(self.belief.covariance) <= FOUND_SIGMA**2).all())


class Node(NamedTuple):
    """A variable of the graph, and how far its stamp lies from the one that was asked for."""

    key: int
    gap_s: float

    @classmethod
    def of(cls, track: Track, stamp_ns: int) -> Node | None:
        """Return the nearest of a track's variables, or None where it has none yet."""
        after = bisect_left(track.stamps_ns, stamp_ns)
        near = [number for number in (after - 1, after) if 0 <= number < len(track.stamps_ns)]
        nodes = [cls(track.key(number), abs(track.stamps_ns[number] - stamp_ns) * 1e-9) for number in near]
        return min(nodes, key=lambda node: node.gap_s, default=None)


def _number_of(stamps_ns: list[int], stamp_ns: int) -> int | None:
    """Return which of some stamps, ascending, a stamp is; None where it is none of them."""
    number = bisect_left(stamps_ns, stamp_ns)
    return number if number < len(stamps_ns) and stamps_ns[number] == stamp_ns else None
