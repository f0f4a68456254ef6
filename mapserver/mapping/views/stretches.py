"""A wall that goes round a corner, taken apart: an outline that is not convex is cut into stretches that nearly are.

Seen from inside a room, the corner lies deepest within the outline's convex hull, and a line of sight through it parts the two walls.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import shapely
import shapely.ops

from protocol.geometry import Array

CONVEX_SHARE = 0.85  # of its convex hull that an outline has to fill to stay whole
MOST_CUTS = 3  # one after the other: eight stretches
DEEP_SHARE, MOST_TRIED = 0.7, 4  # corners at least so deep, of the deepest, and so many of them, are tried
BEYOND = 1e3  # a line of sight goes on for so many times the distance of its corner


def stretches_of(outline: shapely.Polygon, eye_m: Array, cuts: int = MOST_CUTS) -> Iterator[shapely.Polygon]:
    """Yield the stretches of an outline seen from above `eye_m`, (2,) [m; arena]; the outline itself where it is nearly convex."""
    if cuts == 0 or outline.area >= CONVEX_SHARE * outline.convex_hull.area:
        yield outline
        return
    for part in _cut(outline, eye_m):
        yield from stretches_of(part, eye_m, cuts - 1)


def _cut(outline: shapely.Polygon, eye_m: Array) -> list[shapely.Polygon]:
    """Return what is left and right of a line of sight: of those through the deepest corners, the one that cuts most evenly."""
    corners = shapely.get_coordinates(outline)[:-1]
    depths_m = shapely.distance(shapely.points(corners), outline.convex_hull.exterior)
    deep = corners[depths_m >= DEEP_SHARE * depths_m.max()]
    chosen = deep[np.unique(np.linspace(0, len(deep) - 1, MOST_TRIED).astype(int))]
    return max((_parts(outline, eye_m, corner) for corner in chosen), key=_smallest_m2)


def _parts(outline: shapely.Polygon, eye_m: Array, corner: Array) -> list[shapely.Polygon]:
    sight = shapely.LineString([eye_m, eye_m + BEYOND * (corner - eye_m)])
    return [part for part in shapely.ops.split(outline, sight).geoms if isinstance(part, shapely.Polygon)]


def _smallest_m2(parts: list[shapely.Polygon]) -> float:
    return min(part.area for part in parts) if len(parts) > 1 else 0.0
