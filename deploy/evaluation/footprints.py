"""Comparing two footprints on the floor: overlap, and distance from the centre line of a narrow one. All lengths in metres."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray

_STEP_M = 0.005  # outlines and lines are compared at points this far apart


class CentreLine(NamedTuple):
    """The long middle line of a footprint's tightest rectangle, and that rectangle's width."""

    line: shapely.LineString
    width_m: float


def intersection_over_union(a: shapely.Geometry, b: shapely.Geometry) -> float:
    """Return the shared part of two footprints, 0 to 1."""
    union_m2 = a.union(b).area
    return float(a.intersection(b).area / union_m2) if union_m2 else 0.0


def centre_line(footprint: shapely.Polygon) -> CentreLine:
    """Return the line between the middles of the short sides of the tightest rectangle round a footprint."""
    corners = np.array(shapely.oriented_envelope(footprint).exterior.coords)[:4]
    sides_m = np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1)
    if sides_m[0] > sides_m[1]:
        corners, sides_m = np.roll(corners, -1, axis=0), np.roll(sides_m, -1)
    return CentreLine(shapely.LineString([corners[:2].mean(axis=0), corners[2:].mean(axis=0)]), float(sides_m[0]))


def centre_line_error_m(line: CentreLine, footprint: shapely.Geometry) -> float:
    """Return how far a footprint is from a narrow thing: 0 where it covers its centre line and is no wider than it.

    The larger of two means, so that neither a gap nor a smear goes unseen: from the line's points to the footprint, and from
    the footprint's outline to the line, less half the thing's own width.
    """
    to_footprint_m = shapely.distance(_points_along(line.line), footprint)
    to_line_m = shapely.distance(_points_along(footprint.boundary), line.line)
    return float(max(np.mean(to_footprint_m), np.mean(np.maximum(to_line_m - 0.5 * line.width_m, 0.0))))


def _points_along(curve: shapely.Geometry) -> NDArray[np.object_]:
    points: NDArray[np.object_] = shapely.get_parts(shapely.extract_unique_points(shapely.segmentize(curve, _STEP_M)))
    return points
