"""The footprint of an upright thing from its outlines in several views, and from its height.

A prism of height h on a footprint F, seen from height H above the point e, covers on the floor the hull of F and of F stretched from e by
s = H / (H - h), where its top edge appears. So in one view F is what the outline O and O shrunk towards e by s have in common: the near
border of O is the base line, and the far border is the top edge, s times too far out. With the height known, every view gives the whole
footprint, its hidden side included, and the views vote.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from statistics import median
from typing import NamedTuple

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray

from mapserver.mapping.floor.raster import SHIFT_BITS, corners_of, fill
from mapserver.mapping.footprints.base_line import deepest_m, own_base, swept, way_behind
from mapserver.mapping.footprints.carving import carved
from mapserver.mapping.views.silhouette import Extent, Silhouette, shrink
from protocol.geometry import Array

RASTER_M = 0.005  # cells in which views vote
MAJORITY = 0.72  # of the most votes that any cell has makes a cell part of the footprint; things that touch make outlines too large
LEAST_AGREED = 0.5  # of the area of a typical single vote
SMALL_M = 0.15  # what is no deeper need not have a base line as long
LONG_M, WALL_M = 0.6, 0.15  # a base line as long is that of a wall, which goes on behind it for at least this
MARGIN_M = WALL_M + 0.01  # of the raster around all that is drawn
THINNEST = np.ones((3, 3), np.uint8)  # 1.5 cm: what is left thinner between bare floor is no part of a thing
LEAST_WIDTH_SHARE = 0.35  # of the widest view: what shows less is no view of the whole thing
MOST_WIDTH_SHARE, WIDE_M = 2.0, 0.4  # of the base line's length: a wider view shows something else as well, unless it is no wider than this
BASE_WORTH = 8.0  # of a cell of the base line, in cells that only look to be part of the thing, or not
NEAR_BASE = np.ones((9, 9), np.uint8)  # 2 cm to all sides
LEAST_SQUARE_HEIGHT, MOST_SQUARE_HEIGHT = 0.02, 0.7  # that a thing of unknown height may have [camera heights]
MOST_DEPTH = 2.0  # of a thing, along the line of sight, in its widths: what looks deeper is higher than was told, or two things


class Vote(NamedTuple):
    """The cells that one view is for."""

    weight: float
    first: NDArray[np.int_]  # (2,) column and row of the first cell in the raster that all views vote in
    cells: NDArray[np.uint8]  # 1 where it is


# Tells where the floor was seen bare, (rows, columns), at x (columns,) and y (rows,), both growing [m; arena].
IsBare = Callable[[Array, Array], NDArray[np.bool_]]


class Ground(NamedTuple):
    """What is known of the floor about a thing."""

    is_bare: IsBare
    base_m: Array  # (n, 2) centres of the cells in which the thing's own base line was seen [arena]; may be empty


class Footprint(NamedTuple):
    """Where a thing stands."""

    base: shapely.Polygon  # convex [arena]
    centre_m: Array  # (2,) of the base [arena]
    disagreement: Array  # (2, 2) [m^2; arena]: second moments of the single views' centres about that of the base


def footprint(views: Sequence[Silhouette], height_m: float | None, ground: Ground | None = None) -> Footprint | None:
    """Return the footprint that most views agree on and the ground bears out; None where no view gives any.

    A thing of unknown height is taken to be about as deep as it is wide. A view that shows less of its width counts for less, and one that
    shows much more, and so something else as well, counts only where there is no other. Its own base line is part of the footprint, floor
    that was seen bare is not, and no part of it is farther from the base line than that one's shape allows. A height that puts the thing
    beside its base line, or that a view shows to be too much, is not believed.
    """
    views, base_m = own_base(views, np.empty((0, 2)) if ground is None else ground.base_m)
    views, widest_m = whole_views(views, base_m)
    pairs = [_with_shrunk(view, height_m) for view in views]
    lowest = np.array([pair.min(axis=1).max(axis=0) for pair in pairs])  # of the box that the outline and the shrunk one have in common
    highest = np.array([pair.max(axis=1).min(axis=0) for pair in pairs])
    overlap = np.flatnonzero((lowest < highest).all(axis=1))
    if not len(overlap):
        return None
    origin = np.vstack([lowest[overlap], base_m]).min(axis=0) - MARGIN_M
    first = np.floor((lowest[overlap] - origin) / RASTER_M).astype(int) - 1
    beyond = np.ceil((highest[overlap] - origin) / RASTER_M).astype(int) + 2
    votes = [
        Vote(views[index].weight * views[index].extent.width_m / widest_m, low, cells)
        for index, low, high in zip(overlap.tolist(), np.maximum(first, 0), beyond, strict=True)
        if (cells := _common(pairs[index], origin, low, high)) is not None
    ]
    if not votes:
        return None
    size = np.vstack([beyond, np.ceil((base_m + MARGIN_M - origin) / RASTER_M).astype(int)]).max(axis=0)
    agreed = _majority(votes, size)
    base_line = _painted(base_m, origin, agreed.shape)
    if height_m is not None and len(base_m) and not (agreed & (cv2.dilate(base_line, NEAR_BASE) > 0)).any():
        return footprint(views, None, ground)
    bare = _bare(ground, agreed.shape, origin)
    kept = _on_ground(agreed, bare, base_m, base_line, views)
    worth = kept + (BASE_WORTH - 1.0) * base_line.astype(np.float32) - (bare & ~kept)
    base = _hull(carved(worth.astype(np.float32)), origin)
    centre_m = shapely.get_coordinates(shapely.centroid(base))[0]
    return Footprint(base, centre_m, _second_moments(_centres(votes, origin) - centre_m))


def whole_views(views: Sequence[Silhouette], base_m: Array) -> tuple[list[Silhouette], float]:
    """Return the views that show the thing whole and alone, as far as its base line, (n, 2) [m], tells, and the widest one's width [m]."""
    most_m = max(MOST_WIDTH_SHARE * float(np.hypot(*np.ptp(base_m, axis=0))), WIDE_M) if len(base_m) else math.inf
    alone = [view for view in views if view.extent.width_m <= most_m] or views
    widest_m = max(view.extent.width_m for view in alone)
    return [view for view in alone if view.extent.width_m >= LEAST_WIDTH_SHARE * widest_m], widest_m


def _with_shrunk(view: Silhouette, height_m: float | None) -> Array:
    """Return a view's outline and its copy drawn towards the eye by the thing's height, shape (2, n, 2) [m; arena]."""
    scale = _scale_for(view.extent, 1.0)
    if height_m is not None and not view.is_too_short_for(height_m):
        scale = min(float(shrink(height_m, view.eye_height_m)), _scale_for(view.extent, MOST_DEPTH))
    return np.stack([view.corners, view.eye_m + scale * (view.corners - view.eye_m)])


def _scale_for(extent: Extent, depth: float) -> float:
    """Return the scale at which the thing becomes `depth` times as deep, along the line of sight, as it is wide across."""
    if extent.far_m <= depth * extent.width_m:
        return 1.0
    # The width is that of the top, s times too wide, as is its distance: far / s - near = depth * width / s.
    scale = extent.near_m / (extent.far_m - depth * extent.width_m)
    return min(max(scale, 1.0 - MOST_SQUARE_HEIGHT), 1.0 - LEAST_SQUARE_HEIGHT)


def _common(pair: Array, origin: Array, first: NDArray[np.int_], beyond: NDArray[np.int_]) -> NDArray[np.uint8] | None:
    """Return the cells from `first` to before `beyond` that two outlines, shape (2, n, 2) [m; arena], have in common.

    None where there are no such cells, or where they fall apart, as of two things.
    """
    columns, rows = beyond - first
    masks = np.zeros((2, rows, columns), np.uint8)
    for mask, corners in zip(masks, corners_of(pair, origin, RASTER_M) - (first << SHIFT_BITS), strict=True):
        fill(mask, corners.astype(np.int32), 1)
    common = masks[0] & masks[1]
    pieces, _ = cv2.findContours(common, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    return common if len(pieces) == 1 else None


def _majority(votes: Sequence[Vote], size: NDArray[np.int_]) -> NDArray[np.bool_]:
    """Return the cells, of as many columns and rows, (2,), that most of the votes' weight is for.

    Where votes are shifted against each other so much that these are fewer than half of a typical vote's, return those with most weight.
    """
    count = np.zeros(size[::-1], np.float32)
    for weight, (column, row), cells in votes:
        rows, columns = cells.shape
        count[row : row + rows, column : column + columns] += np.float32(weight) * cells
    agreed = np.asarray(count > MAJORITY * sum(vote.weight for vote in votes))
    least = math.ceil(LEAST_AGREED * median(cv2.countNonZero(vote.cells) for vote in votes))
    if cv2.countNonZero(agreed.view(np.uint8)) >= least:
        return agreed
    voted = count[count > 0.0]
    return np.asarray(agreed | (count >= np.partition(voted, -least)[-least]))


def _painted(cells_m: Array, origin: Array, shape: tuple[int, ...]) -> NDArray[np.uint8]:
    """Return a raster with 1 in the grid's cells of which the centres, (n, 2) [m; arena], are given: two by two of the raster's own."""
    painted = np.zeros(shape, np.uint8)
    right, up = np.floor((cells_m - origin) / RASTER_M).astype(int).T
    for rows, columns in ((up, right), (up - 1, right), (up, right - 1), (up - 1, right - 1)):
        painted[rows, columns] = 1
    return painted


def _bare(ground: Ground | None, shape: tuple[int, ...], origin: Array) -> NDArray[np.bool_]:
    """Return where the ground was seen bare, in a raster."""
    rows, columns = shape
    if ground is None:
        return np.zeros((rows, columns), np.bool_)
    return ground.is_bare(origin[0] + (np.arange(columns) + 0.5) * RASTER_M, origin[1] + (np.arange(rows) + 0.5) * RASTER_M)


def _on_ground(
    agreed: NDArray[np.bool_], bare: NDArray[np.bool_], base_m: Array, base_line: NDArray[np.uint8], views: Sequence[Silhouette]
) -> NDArray[np.bool_]:
    """Return the cells that views agree on, less bare floor and what is too far from the base line, and with that.

    A wall goes on behind its base line: before it, towards those who saw it, is floor, however seldom that was seen.
    """
    kept = np.asarray(cv2.morphologyEx((agreed & ~bare).view(np.uint8), cv2.MORPH_OPEN, THINNEST) > 0)
    if len(base_m):
        length_m = float(np.hypot(*np.ptp(base_m, axis=0)))
        if length_m < LONG_M:
            far_m = cv2.distanceTransform(1 - base_line, cv2.DIST_L2, cv2.DIST_MASK_3) * RASTER_M
            kept &= far_m < max(deepest_m(base_m), SMALL_M)
        else:
            kept |= swept(base_line, way_behind(base_m, views), round(WALL_M / RASTER_M)) & ~bare
        kept |= base_line > 0
    return kept if kept.any() else agreed


def _hull(corners: NDArray[np.int_], origin: Array) -> shapely.Polygon:
    """Return a convex polygon, (n, 2) columns and rows, in the arena, grown by the half cells that a border through centres cuts off."""
    ring = shapely.linestrings((np.vstack([corners, corners[:1]]) + 0.5) * RASTER_M + origin)
    grown = shapely.buffer(shapely.convex_hull(ring), 0.5 * RASTER_M, quad_segs=1, join_style="mitre")
    hull: shapely.Polygon = shapely.simplify(grown, 0.5 * RASTER_M)
    return hull


def _centres(votes: Sequence[Vote], origin: Array) -> Array:
    """Return the centres, (n, 2) [m; arena], of the cells of votes."""
    return (np.array([vote.first + _mean_cell(vote.cells) for vote in votes]) + 0.5) * RASTER_M + origin


def _mean_cell(cells: NDArray[np.uint8]) -> Array:
    """Return the mean column and row, (2,), of the cells that are 1."""
    by_column, by_row = (cv2.reduce(cells, axis, cv2.REDUCE_SUM, dtype=cv2.CV_32S).ravel() for axis in (0, 1))
    moments = np.array([by_column @ np.arange(len(by_column)), by_row @ np.arange(len(by_row))], dtype=np.float64)
    return moments / float(by_row.sum())


def _second_moments(offsets: Array) -> Array:
    """Return the second moments, (2, 2), of points at some offsets, (n, 2), from a centre."""
    return np.asarray(offsets.T @ offsets / len(offsets))
