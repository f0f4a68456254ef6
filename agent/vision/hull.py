"""Outlines and centres of objects: the convex hull of the outer corrected points, and the object centre of the paper's Eq. 8."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from protocol.errors import GeometryError
from protocol.geometry import Array

LEAST_CORNERS = 3  # of an area
_FLAT = 1e-6  # area over the square of the extent, below which a polygon is a line


def convex_hull(points: Array) -> Array:
    """Return the outer points, shape (m, 2), of points (n, 2), counter-clockwise where x points right and y up.

    NaN points are left out. Where all points lie on a line, its two ends are left, or its one point.
    """
    finite = points[np.isfinite(points).all(axis=1)]
    single = finite.astype(np.float32)  # decides which points are outer; they are returned as given
    if (single == single[:1]).all():
        return finite[:1]
    outer = cv2.convexHull(single, clockwise=False, returnPoints=False)
    return np.asarray(finite[outer.ravel()])


def hulls_by_label(points: Array, labels: NDArray[np.integer]) -> dict[int, Array]:
    """Return the convex hull of the points, shape (n, 2), of every label (n,) above 0 that has a finite point."""
    finite = np.isfinite(points).all(axis=1) & (labels > 0)
    return {int(label): convex_hull(points[finite & (labels == label)]) for label in np.unique(labels[finite])}


def overlap(first: Array, second: Array) -> float:
    """Return the area that two convex polygons, (n, 2) and (m, 2), have in common."""
    if min(len(first), len(second)) < LEAST_CORNERS:
        return 0.0
    return float(cv2.intersectConvexConvex(first.astype(np.float32), second.astype(np.float32))[0])


def centre_of_region(brightness: NDArray[np.generic]) -> Array:
    """Return the object centre, shape (2,) [px: x, y], of a picture (h, w): the mean place of its pixels that are not 0; Eq. 8.

    Raises GeometryError where every pixel is 0.
    """
    rows, columns = np.nonzero(brightness)
    if not len(rows):
        raise GeometryError("object centre: the region has no pixel")
    return np.array([columns.mean(), rows.mean()])


def centre_of_polygon(vertices: Array) -> Array:
    """Return the object centre, shape (2,), of a polygon (n, 2): Eq. 8 with its inside bright and everything else dark.

    A polygon without area, such as a cable seen as a line, has its centre half way between its ends. Raises GeometryError where a vertex is
    not finite, or there is none.
    """
    if not len(vertices) or not np.isfinite(vertices).all():
        raise GeometryError(f"object centre: the polygon needs finite vertices, not {vertices.tolist()}")
    middle = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
    here = vertices - middle  # near the origin single precision is enough
    moments = cv2.moments(here.astype(np.float32)[:, None])
    area = moments["m00"]
    if area <= _FLAT * np.square(here).sum():
        return np.asarray(middle)
    return np.asarray(middle + np.array([moments["m10"], moments["m01"]]) / area)
