"""How far a thing's base reaches in each direction, as every view tells it: its support function.

A prism on a base F covers on the floor the hull of F and of F stretched from the point under the eye by s = H / (H - h) (prism.py). The
support function of a hull is the larger of both, and counted from that point F's own where it is negative, towards the eye, and s times F's
where it is positive, away from it. So each outline tells F's support function in all directions: by the base line on the near side, and on
the far side by the top edge, as well as the height is known.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from mapserver.mapping.views.silhouette import Silhouette, shrink
from protocol.geometry import Array

DIRECTIONS = 36
OUTLINE_SIGMA_RAD, OUTLINE_SIGMA_M = 0.004, 0.004  # of an outline: two pixels, and the soft shadow where a thing meets the floor
TOP_SIGMA_M = 0.01  # by which one view's top edge may be that of another height than all views have in common

_TURN = np.arange(DIRECTIONS) * (2.0 * np.pi / DIRECTIONS)
NORMALS = np.stack([np.cos(_TURN), np.sin(_TURN)], axis=-1)  # (DIRECTIONS, 2)


class Reach(NamedTuple):
    """The support function of a base, counted from some origin, as views tell it; all of shape (views, DIRECTIONS)."""

    told_m: Array
    sigmas_m: Array
    by_height: Array  # how much less that is for each metre that the thing is higher; 0 where the base line tells [m/m]


def reach_of(views: Sequence[Silhouette], height_m: float, origin_m: Array) -> Reach:
    """Return how far, from an origin, (2,) [m; arena], the base of a thing of some height reaches in the directions of NORMALS."""
    eyes_m = np.array([view.eye_m for view in views])
    eye_heights_m = np.array([view.eye_height_m for view in views])[:, None]
    farthest_m = np.array([_farthest(view) for view in views])  # (views, DIRECTIONS, 2), from the point under the eye
    seen_m = np.sum(farthest_m * NORMALS, axis=-1)
    shrinks = np.array([shrink(height_m, view.eye_height_m) for view in views])[:, None]
    by_height = np.maximum(seen_m, 0.0) / eye_heights_m
    scale = np.where(seen_m > 0.0, shrinks, 1.0)
    sigmas_m = np.hypot(scale * _sigmas(farthest_m, eye_heights_m), TOP_SIGMA_M * by_height)
    return Reach(scale * seen_m + (eyes_m - origin_m) @ NORMALS.T, sigmas_m, by_height)


def support_of(corners_m: Array) -> Array:
    """Return the support function, (DIRECTIONS,) [m], of a polygon with corners (n, 2), counted from where these are."""
    return np.asarray((corners_m @ NORMALS.T).max(axis=0))


def _farthest(view: Silhouette) -> Array:
    """Return the outline's corners that lie farthest in each direction, (DIRECTIONS, 2) [m], from the point under the eye."""
    offsets_m = view.corners - view.eye_m
    return np.asarray(offsets_m[(offsets_m @ NORMALS.T).argmax(axis=0)])


def _sigmas(points_m: Array, eye_heights_m: Array) -> Array:
    """Return how well the outline is known at points, (views, DIRECTIONS, 2), across its border, in the directions of NORMALS [m].

    An angle in the picture is longer on the floor along the line of sight than across it, by the distance over the height.
    """
    squared_m2 = np.sum(points_m**2, axis=-1)
    along = np.sum(points_m * NORMALS, axis=-1) ** 2 / np.maximum(squared_m2, 1e-12)
    slant_m2 = eye_heights_m**2 + squared_m2
    variance_m2 = OUTLINE_SIGMA_RAD**2 * slant_m2 * (along * slant_m2 / eye_heights_m**2 + 1.0 - along)
    return np.asarray(np.sqrt(variance_m2 + OUTLINE_SIGMA_M**2))
