"""What one view shows of an upright thing: its outline on the floor, smeared away from the eye by its height, and the height itself."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray

from protocol.geometry import Array

HEIGHT_QUANTILE = 0.85  # of the heights seen: corners below the top are told more often than any above it
LEAST_HEIGHTS = 2
MARGIN_M = 0.03  # what lies so near to an outline belongs to it
MOST_HEIGHT = 0.95  # of what stands as tall as the camera, or taller, no top is seen [camera heights]


@dataclass(frozen=True, eq=False)
class Silhouette:
    """One view of one thing."""

    eye_m: Array  # (2,) point under the camera [arena]
    eye_height_m: float
    outline: shapely.Polygon  # without holes [arena]
    weight: float  # how well this view resolves the thing, 0 to 1

    @cached_property
    def corners(self) -> Array:
        """The outline's corners, (n, 2) [m; arena], the first of them repeated at the end."""
        return np.asarray(shapely.get_coordinates(self.outline))

    @cached_property
    def lowest_m(self) -> Array:
        """The lowest corner, (2,) [m; arena], of the box around the outline."""
        return np.asarray(self.corners.min(axis=0))

    @cached_property
    def highest_m(self) -> Array:
        """The highest corner, (2,) [m; arena], of the box around the outline."""
        return np.asarray(self.corners.max(axis=0))

    @cached_property
    def centre_m(self) -> Array:
        """The outline's centroid, (2,) [m; arena]."""
        return np.asarray(shapely.get_coordinates(shapely.centroid(self.outline))[0])

    @cached_property
    def surroundings(self) -> shapely.Geometry:
        """The outline grown by MARGIN_M, prepared for many points."""
        grown = shapely.buffer(self.outline, MARGIN_M, quad_segs=1)
        shapely.prepare(grown)
        return grown

    def is_too_short_for(self, height_m: float) -> bool:
        """Tell whether the outline ends before the top of a thing of this height would appear, even without any depth.

        Either the view told only part of the thing from the floor, or the height is another's.
        """
        return bool(self.extent.far_m * shrink(height_m, self.eye_height_m) < self.extent.near_m)

    @cached_property
    def extent(self) -> Extent:
        """How far the outline reaches."""
        offsets, towards = self.corners - self.eye_m, self.centre_m - self.eye_m
        towards = towards / max(float(np.hypot(*towards)), 1e-9)
        along, across = offsets @ towards, offsets @ np.array([-towards[1], towards[0]])
        return Extent(float(along.min()), float(along.max()), float(np.ptp(across)))


class Extent(NamedTuple):
    """How far an outline reaches along the line of sight to its centre, from the eye, and how wide it is across."""

    near_m: float
    far_m: float
    width_m: float


class SeenHeight(NamedTuple):
    """The height of a thing's top as one view told it, and that view's weight."""

    height_m: float
    weight: float


def height_of(seen: Sequence[SeenHeight]) -> float | None:
    """Return the height [m] that the views tell by their weight; None where fewer than two do."""
    if len(seen) < LEAST_HEIGHTS:
        return None
    heights, weights = np.array(sorted(seen)).T
    return float(heights[np.searchsorted(np.cumsum(weights), HEIGHT_QUANTILE * weights.sum())])


def silhouettes_of(bases: Sequence[shapely.Polygon], heights_m: Array, eye_m: Array, eye_height_m: float) -> NDArray[np.object_]:
    """Return what prisms on convex `bases` cover on the floor, polygons (n,) [arena]: each the hull of base and stretched top."""
    corners, owners = shapely.get_coordinates(bases, return_index=True)
    stretch = 1.0 / shrink(heights_m, eye_height_m)
    tops = eye_m + stretch[owners, None] * (corners - eye_m)
    order = np.argsort(np.concatenate([owners, owners]), kind="stable")
    clouds = shapely.linestrings(np.concatenate([corners, tops])[order], indices=np.concatenate([owners, owners])[order])
    return np.asarray(shapely.convex_hull(clouds), dtype=np.object_)


def shrink(height_m: Array | float, eye_height_m: float) -> Array:
    """Return 1 / s: by how much nearer a top of this height stands than it appears."""
    return 1.0 - np.minimum(np.asarray(height_m) / eye_height_m, MOST_HEIGHT)
