"""A thing's base line: whether it is its own, which views show it, how far it reaches and what lies behind it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely
from numpy.typing import NDArray

from mapserver.mapping.views.silhouette import MARGIN_M, Silhouette
from protocol.geometry import Array

LEAST_BASE_CELLS = 15  # fewer are no base line
OWN_SHARE = 0.15  # of a base line within the outlines, grown by a margin: one that shows less is another thing's
BEFORE_BASE_M = 0.3  # what begins so much nearer to the eye than a base line is another thing, before it
BEND_WORTH = 0.55  # of depth that a base line shows by bending
STRAIGHT_M = 0.03  # the width of a base line that does not
BASE_STEP_M = 0.06  # a base line that reaches less farther, or less far, is nearly the same


def own_base(views: Sequence[Silhouette], base_m: Array) -> tuple[Sequence[Silhouette], Array]:
    """Return the views that show any of a base line, (n, 2) [m; arena], and that; all views, and none, where it is another thing's.

    A thing that has once come to stand on another's base line would otherwise stay there, however many views show it elsewhere, and one
    that was taken for two things would keep the views of both.
    """
    if len(base_m) < LEAST_BASE_CELLS:
        return views, np.empty((0, 2))
    weights = np.array([view.weight * view.extent.width_m for view in views])
    shares = np.array([_shown_share(base_m, view) for view in views])
    if weights @ shares < OWN_SHARE * weights.sum():
        return views, np.empty((0, 2))
    return [view for view, share in zip(views, shares, strict=True) if share > 0.0], base_m


def lies_beside(base_m: Array, base: shapely.Polygon) -> bool:
    """Tell whether no part of a base line, (n, 2) [m; arena], lies in a footprint, so that it cannot be its own."""
    return len(base_m) >= LEAST_BASE_CELLS and not shapely.contains_xy(shapely.buffer(base, MARGIN_M, quad_segs=1), *base_m.T).any()


def reaches_as_far(first_m: Array, second_m: Array) -> bool:
    """Tell whether the boxes around two base lines, (n, 2) [m; arena] each, are nearly the same; that around none is like no other."""
    if not len(first_m) or not len(second_m):
        return len(first_m) == len(second_m)
    boxes_m = [np.concatenate([base_m.min(axis=0), base_m.max(axis=0)]) for base_m in (first_m, second_m)]
    return bool(np.abs(boxes_m[0] - boxes_m[1]).max() <= BASE_STEP_M)


def deepest_m(base_m: Array) -> float:
    """Return how far behind its base line, (n, 2) [m; arena], a thing may reach at most [m].

    Behind a straight one that is as far as it is long. One that bends, round a corner or a cylinder, shows more of the thing: from near
    sides that are l from end to end and bend by l / 2, the far corner of a square is 0.71 l away, and so is the back of a cylinder.
    """
    length_m = float(np.hypot(*np.ptp(base_m, axis=0)))
    offsets_m = base_m - base_m.mean(axis=0)
    bend_m = float(np.ptp(offsets_m @ np.linalg.eigh(offsets_m.T @ offsets_m)[1][:, 0]))
    return length_m - BEND_WORTH * max(bend_m - STRAIGHT_M, 0.0)


def way_behind(base_m: Array, views: Sequence[Silhouette]) -> Array:
    """Return the direction, (2,) of length 1, across a base line, (n, 2) [m; arena], that leads away from the eyes."""
    middle_m = base_m.mean(axis=0)
    across = np.linalg.eigh((base_m - middle_m).T @ (base_m - middle_m))[1][:, 0]
    line_of_sight_m = middle_m - np.average([view.eye_m for view in views], axis=0, weights=[view.weight for view in views])
    return np.asarray(across if across @ line_of_sight_m >= 0.0 else -across)


def swept(base_line: NDArray[np.uint8], way: Array, cells: int) -> NDArray[np.bool_]:
    """Return a base line in a raster, and the cells up to so many farther, on its `way`, (2,) column and row, of length 1."""
    moves = np.unique(np.rint(np.arange(cells + 1)[:, None] * way).astype(int), axis=0)
    rows, columns = base_line.shape
    covered = np.zeros(base_line.shape, np.bool_)
    for right, up in moves.tolist():
        into = covered[max(up, 0) : rows + min(up, 0), max(right, 0) : columns + min(right, 0)]
        into |= base_line[max(-up, 0) : rows - max(up, 0), max(-right, 0) : columns - max(right, 0)] > 0
    return covered


def _shown_share(base_m: Array, view: Silhouette) -> float:
    """Return how much, 0 to 1, of a base line, (n, 2) [m; arena], a view shows; 0 where what it shows begins nearer to the eye."""
    shown = shapely.contains_xy(view.surroundings, *base_m.T)
    if not shown.any():
        return 0.0
    begins_m, base_begins_m = (float(np.hypot(*(points - view.eye_m).T).min()) for points in (view.corners, base_m[shown]))
    return float(shown.mean()) if base_begins_m < begins_m + BEFORE_BASE_M else 0.0
