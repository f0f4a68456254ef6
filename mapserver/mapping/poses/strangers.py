"""Robots without a place that sight things by name, or are sighted: where they must be, and what waits to be tied until they are there.

Every such sighting is a pair of points: one in the robot's own odom frame, the same one in the arena. Two pairs tell the motion from
one frame to the other; what most pairs agree on is it. Fischler and Bolles, "Random sample consensus", CACM 1981, with all samples tried.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from mapserver.mapping.poses.association import sighted_point, sighting_covariance
from protocol.geometry import Array, Pose2
from protocol.messages import LocalMap, Sighting

MEMORY_NS = 60_000_000_000  # how long a sighting waits: dead reckoning of a minute is still one piece
MOST_CLUES = 40  # the newest
LEAST_CLUES = 4  # that agree
AGREEING_SHARE = 0.6  # of all clues
LEAST_BASE_M = 1.0  # between two points that tell a direction
GATE_SIGMAS = 3.0
ELSEWHERE_SIGMA_M = 0.15  # what a clue errs by besides its sighting: where the other stands, and own dead reckoning


class Places(Protocol):
    """Where named things and robots are believed to be."""

    def pose_at(self, robot: str, stamp_ns: int) -> Pose2 | None:
        """Return a placed robot's pose of exactly this stamp, if it has one."""
        ...

    def landmark(self, name: str) -> Array | None:
        """Return a known landmark's position, shape (2,) [m; arena]."""
        ...


class Untied(NamedTuple):
    """A named sighting that nothing could be tied by when it came."""

    local_map: LocalMap
    sighting: Sighting


class Found(NamedTuple):
    """Where a robot was at the stamp of one of its local maps."""

    stamp_ns: int
    arena_from_body: Pose2


class Clue(NamedTuple):
    """The same point in two frames, each of shape (2,) [m], and how far they may lie apart."""

    point_odom: Array
    point_arena: Array
    sigma_m: float


class Strangers:
    """Keeps what is said by and about robots without a place."""

    def __init__(self) -> None:
        self._untied: list[Untied] = []
        self._own: dict[str, list[LocalMap]] = {}

    def hear(self, local_map: LocalMap) -> None:
        """Keep a local map of a robot without a place. A restarted agent begins anew."""
        own = self._own.setdefault(local_map.robot, [])
        if own and own[-1].epoch != local_map.epoch:
            own.clear()
        own.append(local_map)
        self._forget_before(local_map.stamp_ns - MEMORY_NS)

    def keep(self, local_map: LocalMap, sighting: Sighting) -> None:
        """Keep a sighting by, or of, a robot without a place."""
        self._untied.append(Untied(local_map, sighting))
        self._forget_before(local_map.stamp_ns - MEMORY_NS)

    def find(self, robot: str, places: Places) -> Found | None:
        """Return where a robot without a place was at its newest local map, or None where that is not certain."""
        own = {local_map.stamp_ns: local_map for local_map in self._own.get(robot, [])}
        clues = [clue for untied in self._untied if (clue := _clue(robot, untied, own, places)) is not None]
        arena_from_odom = agreed_motion(clues[-MOST_CLUES:])
        if arena_from_odom is None:
            return None
        newest = self._own[robot][-1]
        return Found(newest.stamp_ns, arena_from_odom @ Pose2(*newest.odom_from_body))

    def release(self, robot: str) -> list[Untied]:
        """Return what was kept by or about a robot that has just been placed, oldest first; it is no stranger any more."""
        self._own.pop(robot, None)
        released = [untied for untied in self._untied if robot in _robots_of(untied)]
        self._untied = [untied for untied in self._untied if robot not in _robots_of(untied)]
        return released

    def _forget_before(self, stamp_ns: int) -> None:
        self._untied = [untied for untied in self._untied if untied.local_map.stamp_ns >= stamp_ns]
        self._own = {robot: [kept for kept in own if kept.stamp_ns >= stamp_ns] for robot, own in self._own.items()}


def agreed_motion(clues: Sequence[Clue]) -> Pose2 | None:
    """Return arena_from_odom as most clues agree on it; None where too few do, or where they lie too close together to tell."""
    if len(clues) < LEAST_CLUES:
        return None
    odom, arena = np.array([clue.point_odom for clue in clues]), np.array([clue.point_arena for clue in clues])
    gates_m = GATE_SIGMAS * np.array([clue.sigma_m for clue in clues])
    candidates = [_agreeing(motion, odom, arena, gates_m) for motion in _motions_of_pairs(odom, arena)]
    best = max(candidates, key=lambda agreeing: int(agreeing.sum()), default=np.zeros(len(clues), dtype=bool))
    if best.sum() < max(LEAST_CLUES, AGREEING_SHARE * len(clues)):
        return None
    return fitted_motion(odom[best], arena[best])


def fitted_motion(odom: Array, arena: Array) -> Pose2:
    """Return the motion that moves points, shape (n, 2), best onto others. Umeyama, PAMI 1991, in the plane and without scale."""
    middle_odom, middle_arena = odom.mean(axis=0), arena.mean(axis=0)
    a, b = (odom - middle_odom) @ (1.0, 1.0j), (arena - middle_arena) @ (1.0, 1.0j)
    turn = Pose2(0.0, 0.0, float(np.angle(np.vdot(a, b))))
    x_m, y_m = (middle_arena - turn.apply(middle_odom)).tolist()
    return Pose2(x_m, y_m, turn.theta_rad)


def _motions_of_pairs(odom: Array, arena: Array) -> list[Pose2]:
    pairs = [list(pair) for pair in combinations(range(len(odom)), 2)]
    wide = [pair for pair in pairs if min(_base_m(odom[pair]), _base_m(arena[pair])) >= LEAST_BASE_M]
    return [fitted_motion(odom[pair], arena[pair]) for pair in wide]


def _base_m(pair: Array) -> float:
    return float(np.hypot(*(pair[1] - pair[0])))


def _agreeing(motion: Pose2, odom: Array, arena: Array, gates_m: Array) -> NDArray[np.bool_]:
    return np.asarray(np.hypot(*(motion.apply(odom) - arena).T) <= gates_m)


def _robots_of(untied: Untied) -> tuple[str, ...]:
    identity = untied.sighting.identity
    return (untied.local_map.robot, identity.name) if identity.kind == "robot" else (untied.local_map.robot,)


def _clue(robot: str, untied: Untied, own: dict[int, LocalMap], places: Places) -> Clue | None:
    """Return what a kept sighting says of where a robot is, if it does."""
    stamp_ns, identity = untied.local_map.stamp_ns, untied.sighting.identity
    if robot not in _robots_of(untied) or stamp_ns not in own:
        return None
    odom_from_body = Pose2(*own[stamp_ns].odom_from_body)
    point_body = sighted_point(untied.sighting)
    if untied.local_map.robot == robot:
        point_arena = places.landmark(identity.name) if identity.kind == "landmark" else _position(places.pose_at(identity.name, stamp_ns))
        point_odom = odom_from_body.apply(point_body)
    else:
        observer = places.pose_at(untied.local_map.robot, stamp_ns)
        point_arena = None if observer is None else observer.apply(point_body)
        point_odom = np.array(odom_from_body[:2])
    return None if point_arena is None else Clue(point_odom, point_arena, _sigma_m(untied.sighting))


def _position(pose: Pose2 | None) -> Array | None:
    return None if pose is None else np.array(pose[:2])


def _sigma_m(sighting: Sighting) -> float:
    """Return how far a sighted point may lie off, along or across the line of sight, whichever is more."""
    covariance = sighting_covariance(sighting)
    sighted = max(float(covariance[0, 0]), sighting.range_m**2 * float(covariance[1, 1]))
    return float(np.sqrt(sighted + ELSEWHERE_SIGMA_M**2))
