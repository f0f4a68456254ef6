"""The borders of the things in one local map, as points."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from protocol.geometry import Array
from protocol.messages import LocalMap

SPACING_M = 0.01  # of the points that stand for a thing's border: no body slips through between two
NEAR_M = 0.7  # of the body's origin: things farther away are of no concern yet
ROBOT_MARGIN_M = 0.03  # an outline within this of a robot's body is that robot
EDGE_M = 0.03  # what shows nowhere but this near to the own body's edge is its shadow, or its reflection
SIGHTED = -1  # the label of every robot


class Borders(NamedTuple):
    """Points on the borders of things."""

    points_m: Array  # (n, 2)
    moving: NDArray[np.bool_]  # (n,)

    def joined(self, other: Borders) -> Borders:
        """Return the points of both."""
        return Borders(*(np.concatenate(pair) for pair in zip(self, other, strict=True)))


class SeenBorders(NamedTuple):
    """The same, with the label of the thing that each lies on."""

    points_m: Array  # (n, 2) [body]
    moving: NDArray[np.bool_]  # (n,)
    on_robot: NDArray[np.bool_]  # (n,) or hardly beside one
    labels: NDArray[np.int64]  # (n,)


def seen_borders(local_map: LocalMap, robots_m: Array, body_radius_m: float) -> SeenBorders:
    """Return the borders that a local map shows near the robot: of outlines, and of sighted robots with a body of that radius.

    `robots_m`, (k, 2) [body], is where other robots are, sighted or not.
    """
    bodies = sighted_m(local_map)
    outlines = [region.outline.metres() for region in local_map.regions]
    things = [(region, outline) for region, outline in zip(local_map.regions, outlines, strict=True) if _is_thing(outline, local_map)]
    points, owner = _near_points([outline for _, outline in things])
    on_robot = within(points, np.concatenate([bodies, robots_m]), body_radius_m + ROBOT_MARGIN_M)
    moving = on_robot | np.array([region.motion == "moving" for region, _ in things], dtype=np.bool_)[owner]
    labels = np.array([region.label for region, _ in things], dtype=np.int64)[owner]
    robots = body_borders(bodies, body_radius_m)
    return SeenBorders(
        np.concatenate([points, robots.points_m]),
        np.concatenate([moving, robots.moving]),
        np.concatenate([on_robot, robots.moving]),
        np.concatenate([labels, np.full(len(robots.points_m), SIGHTED)]),
    )


def sighted_m(local_map: LocalMap) -> Array:
    """Return where a local map's sighted robots are, (k, 2) [body]."""
    return np.array([(s.range_m * np.cos(s.bearing_rad), s.range_m * np.sin(s.bearing_rad)) for s in local_map.sightings]).reshape(-1, 2)


def body_borders(centres_m: Array, body_radius_m: float) -> Borders:
    """Return the borders of robots' bodies round centres (k, 2), of those that are near."""
    points = (centres_m[norms(centres_m) < NEAR_M + body_radius_m][:, None] + _circle(body_radius_m)).reshape(-1, 2)
    return Borders(points, np.ones(len(points), dtype=np.bool_))


def along_border(outline_m: Array) -> Array:
    """Return points, (m, 2) [m], along a closed polygon (n, 2), its corners among them, no two neighbours farther apart than SPACING_M."""
    return _along_sides(outline_m, np.roll(outline_m, -1, axis=0))[0]


def _is_thing(outline_m: Array, local_map: LocalMap) -> bool:
    """Tell whether an outline reaches beyond the own body's edge."""
    return bool(norms(outline_m).max() > local_map.body_radius_m + EDGE_M)


def _near_points(outlines_m: Sequence[Array]) -> tuple[Array, NDArray[np.intp]]:
    """Return the points, (m, 2), along outlines that are near the robot, and on which outline each lies, (m,)."""
    if not outlines_m:
        return np.empty((0, 2)), np.empty(0, dtype=np.intp)
    corners, following = np.concatenate(outlines_m), np.concatenate([np.roll(outline, -1, axis=0) for outline in outlines_m])
    owner = np.repeat(np.arange(len(outlines_m)), [len(outline) for outline in outlines_m])
    # Of a wall most sides are far away, and so many points would only be thrown away again.
    near = norms(corners) < NEAR_M + norms(following - corners)
    points, side = _along_sides(corners[near], following[near])
    kept = norms(points) < NEAR_M
    return points[kept], owner[near][side[kept]]


def _along_sides(first_m: Array, last_m: Array) -> tuple[Array, NDArray[np.intp]]:
    """Return points, (m, 2), along sides from `first_m` (n, 2) to before `last_m`, and on which side each lies, (m,)."""
    pieces = np.maximum(np.ceil(norms(last_m - first_m) / SPACING_M).astype(np.int64), 1)
    side = np.repeat(np.arange(len(first_m)), pieces)
    share = (np.arange(len(side)) - np.repeat(np.cumsum(pieces) - pieces, pieces)) / pieces[side]
    return np.asarray(first_m[side] + share[:, None] * (last_m - first_m)[side]), side


def norms(vectors: Array) -> Array:
    """Return the lengths, (n,), of vectors (n, 2)."""
    return np.asarray(np.hypot(vectors[:, 0], vectors[:, 1]))


def within(points_m: Array, others_m: Array, distance_m: float) -> NDArray[np.bool_]:
    """Tell which points, (n, 2), are nearer than a distance to one of some others, (k, 2)."""
    return np.asarray((np.hypot(*(points_m[:, None] - others_m).transpose(2, 0, 1)) < distance_m).any(axis=1))


def _circle(radius_m: float) -> Array:
    """Return points, (n, 2), on a circle round the origin."""
    count = int(np.ceil(2.0 * np.pi * radius_m / SPACING_M))
    angles = 2.0 * np.pi * np.arange(count) / count
    return radius_m * np.column_stack([np.cos(angles), np.sin(angles)])
