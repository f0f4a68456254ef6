"""The footprint of an upright thing from its outlines in several views, and from its height.

A prism of height h on a footprint F, seen from height H above the point e, covers on the floor the hull of F and of F stretched from e by
s = H / (H - h), where its top edge appears. So in one view F is what the outline O and O shrunk towards e by s have in common: the near
border of O is the base line, and the far border is the top edge, s times too far out. With the height known, every view gives the whole
footprint, its hidden side included, and the views vote.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray

from mapserver.mapping.raster import corners_of, fill
from protocol.geometry import Array

RASTER_M = 0.005  # cells in which views vote
MAJORITY = 0.65  # of the most votes that any cell has makes a cell part of the footprint; things that touch make outlines too large
LEAST_AGREED = 0.5  # of the area of a typical single vote
HEIGHT_QUANTILE = 0.6  # of the heights seen: corners below the top are told more often than any above it
LEAST_HEIGHTS = 2
LEAST_SQUARE_HEIGHT, MOST_SQUARE_HEIGHT = 0.02, 0.7  # that a thing of unknown height may have [camera heights]
MOST_HEIGHT = 0.95  # of what stands as tall as the camera, or taller, no top is seen [camera heights]


@dataclass(frozen=True, eq=False)
class Silhouette:
    """One view of one thing."""

    eye_m: Array  # (2,) point under the camera [arena]
    eye_height_m: float
    outline: shapely.Polygon  # without holes [arena]
    weight: float  # how well this view resolves the thing, 0 to 1


class SeenHeight(NamedTuple):
    """The height of a thing's top as one view told it, and that view's weight."""

    height_m: float
    weight: float


class Footprint(NamedTuple):
    """Where a thing stands."""

    base: shapely.Polygon  # convex [arena]
    disagreement: Array  # (2, 2) [m^2; arena]: second moments of the single views' centres about that of the base


def height_of(seen: Sequence[SeenHeight]) -> float | None:
    """Return the height [m] that the views tell by their weight; None where fewer than two do."""
    if len(seen) < LEAST_HEIGHTS:
        return None
    heights, weights = np.array(sorted(seen)).T
    return float(heights[np.searchsorted(np.cumsum(weights), HEIGHT_QUANTILE * weights.sum())])


def footprint(views: Sequence[Silhouette], height_m: float | None) -> Footprint | None:
    """Return the footprint that most views agree on; None where no view gives any.

    A thing of unknown height is taken to be about as deep as it is wide.
    """
    pairs = [_with_shrunk(view, height_m) for view in views]
    lowest = np.array([pair.min(axis=1).max(axis=0) for pair in pairs])  # of the box that the outline and the shrunk one have in common
    highest = np.array([pair.max(axis=1).min(axis=0) for pair in pairs])
    overlap = np.flatnonzero((lowest < highest).all(axis=1)).tolist()
    if not overlap:
        return None
    origin = lowest[overlap].min(axis=0) - RASTER_M
    columns, rows = np.ceil((highest[overlap].max(axis=0) - origin) / RASTER_M).astype(int) + 2
    votes = [(views[index].weight, vote) for index in overlap if (vote := _vote(pairs[index], origin, (int(rows), int(columns)))).any()]
    if not votes:
        return None
    base = _hull(_majority(votes), origin)
    return Footprint(base, _second_moments(_centres([vote for _, vote in votes], origin), base))


def silhouettes_of(bases: Sequence[shapely.Polygon], heights_m: Array, eye_m: Array, eye_height_m: float) -> NDArray[np.object_]:
    """Return what prisms on convex `bases` cover on the floor, polygons (n,) [arena]: each the hull of base and stretched top."""
    corners, owners = shapely.get_coordinates(bases, return_index=True)
    stretch = 1.0 / _shrink(heights_m, eye_height_m)
    tops = eye_m + stretch[owners, None] * (corners - eye_m)
    order = np.argsort(np.concatenate([owners, owners]), kind="stable")
    clouds = shapely.multipoints(np.concatenate([corners, tops])[order], indices=np.concatenate([owners, owners])[order])
    return np.asarray(shapely.convex_hull(clouds), dtype=np.object_)


def _shrink(height_m: Array | float, eye_height_m: float) -> Array:
    """Return 1 / s: by how much nearer a top of this height stands than it appears."""
    return 1.0 - np.minimum(np.asarray(height_m) / eye_height_m, MOST_HEIGHT)


def _with_shrunk(view: Silhouette, height_m: float | None) -> Array:
    """Return a view's outline and its copy drawn towards the eye by the thing's height, shape (2, n, 2) [m; arena]."""
    outline = shapely.get_coordinates(view.outline)
    scale = _square_scale(view) if height_m is None else _shrink(height_m, view.eye_height_m)
    shrunk = view.eye_m + scale * (outline - view.eye_m)
    return np.stack([shrunk if _is_top_only(view, float(scale)) else outline, shrunk])


def _is_top_only(view: Silhouette, scale: float) -> bool:
    """Tell whether an outline is shorter than a thing of this height must appear, so that it cannot begin on the floor.

    Even without any depth, a top appears 1 / scale times as far out as the base. Then only the top was told from the floor.
    """
    along, _ = _along_and_across(view)
    return float(along.max()) * scale < float(along.min())


def _square_scale(view: Silhouette) -> float:
    """Return the scale at which the thing becomes as deep, along the line of sight, as it is wide across."""
    along, across = _along_and_across(view)
    near, far, width = float(along.min()), float(along.max()), float(np.ptp(across))
    if far <= width:
        return 1.0
    # The width is that of the top, s times too wide, as is its distance: far / s - near = width / s.
    return float(np.clip(near / (far - width), 1.0 - MOST_SQUARE_HEIGHT, 1.0 - LEAST_SQUARE_HEIGHT))


def _along_and_across(view: Silhouette) -> tuple[Array, Array]:
    """Return how far an outline's corners are from the eye along the line of sight, (n,) [m], and how far beside it."""
    offsets = shapely.get_coordinates(view.outline) - view.eye_m
    towards = np.asarray(view.outline.centroid.coords[0]) - view.eye_m
    towards = towards / max(float(np.hypot(*towards)), 1e-9)
    return offsets @ towards, offsets @ np.array([-towards[1], towards[0]])


def _vote(pair: Array, origin: Array, shape: tuple[int, ...]) -> NDArray[np.uint8]:
    """Return the cells that two outlines, shape (2, n, 2) [m; arena], have in common; none where these fall apart, as of two things."""
    masks = np.zeros((2, *shape), np.uint8)
    for mask, corners in zip(masks, corners_of(pair, origin, RASTER_M), strict=True):
        fill(mask, corners, 1)
    common = masks[0] & masks[1]
    pieces, _ = cv2.findContours(common, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    return common if len(pieces) == 1 else np.zeros_like(common)


def _majority(votes: Sequence[tuple[float, NDArray[np.uint8]]]) -> NDArray[np.bool_]:
    """Return the cells that most of the votes' weight is for.

    Where votes are shifted against each other so much that these are fewer than half of a typical vote's, return those with most weight.
    """
    count = np.zeros(votes[0][1].shape, np.float32)
    for weight, vote in votes:
        count += np.float32(weight) * vote
    least = math.ceil(LEAST_AGREED * np.median([cv2.countNonZero(vote) for _, vote in votes]))
    most_weight = np.partition(count, -least, axis=None)[-least]
    return np.asarray((count > MAJORITY * sum(weight for weight, _ in votes)) | ((count >= most_weight) & (count > 0.0)))


def _hull(mask: NDArray[np.bool_], origin: Array) -> shapely.Polygon:
    """Return the convex hull of a mask's largest piece, grown by the half cells that a border through centres cuts off."""
    contours, _ = cv2.findContours(mask.view(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    largest = np.asarray(max(contours, key=cv2.contourArea))[:, 0]
    cells = shapely.MultiPoint((largest + 0.5) * RASTER_M + origin).convex_hull
    return cells.buffer(0.5 * RASTER_M, quad_segs=1, join_style="mitre").simplify(0.5 * RASTER_M)


def _centres(masks: Sequence[NDArray[np.uint8]], origin: Array) -> Array:
    """Return the centres, (n, 2) [m; arena], of masks."""
    moments = [cv2.moments(mask, binaryImage=True) for mask in masks]
    return (np.array([(m["m10"] / m["m00"], m["m01"] / m["m00"]) for m in moments]) + 0.5) * RASTER_M + origin


def _second_moments(centres: Array, base: shapely.Polygon) -> Array:
    """Return the second moments, (2, 2), of points, (n, 2), about the centre of the base."""
    offsets = centres - np.asarray(base.centroid.coords[0])
    return np.asarray(offsets.T @ offsets / len(offsets))
