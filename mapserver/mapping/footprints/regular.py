"""A thing's footprint as a circle or a rectangle, where one of them explains what was seen of it.

What stands in rooms is mostly round or right-angled. Seen from one side, a third of a circle or two sides of a box tell all of it; and seen
from everywhere, the errors of views cancel out in three or five numbers, where they add up in a hull of all that many of them show.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import shapely

from mapserver.mapping.footprints.base_line import own_base
from mapserver.mapping.footprints.prism import LONG_M, Footprint, Ground, whole_views
from mapserver.mapping.footprints.shape_fit import cost_of, fitted_circle, fitted_rectangle
from mapserver.mapping.footprints.support import Reach, reach_of, support_of
from mapserver.mapping.views.silhouette import Silhouette
from protocol.geometry import Array

LEAST_RADIUS_M, MOST_RADIUS_M = 0.01, 0.5 * LONG_M  # and half sides: what is smaller is grain, what is larger a wall
BARE_COST = 2.0  # of a footprint that is all bare floor; where a thing looks like the floor, some of it is held to be bare
UNCOVERED_COST, MOST_UNCOVERED = 5.0, 0.5  # of one with nothing of the base line in it; most of that has to be, for it was seen
BETTER = 0.9  # of the cost of the rough footprint, which takes in the errors of views: a shape has to cost less
BASE_MARGIN_M = 0.006  # half a cell of the base line
SAMPLE_M = 0.005
CORNERS_OF_QUARTER = 6
BOX = np.array([(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)])


class _Explanation(NamedTuple):
    """A footprint, and what it does not explain of what was seen."""

    base: shapely.Polygon
    cost: float  # of how the outlines fit
    bare: float  # 0 to 1, of the footprint, that was seen bare
    uncovered: float  # 0 to 1, of the base line, that does not lie in it

    def total(self) -> float:
        """Return the cost of all that."""
        return self.cost + BARE_COST * self.bare + UNCOVERED_COST * self.uncovered


def regular(rough: Footprint, views: Sequence[Silhouette], height_m: float, ground: Ground) -> Footprint | None:
    """Return the circle or rectangle that explains the views of a thing, the bare floor and its base line better than its rough footprint.

    None where none does, and of a wall.
    """
    views, base_m = own_base(views, ground.base_m)
    views, _ = whole_views(views, base_m)
    if len(base_m) and float(np.hypot(*np.ptp(base_m, axis=0))) > LONG_M:
        return None
    reach = reach_of(views, height_m, rough.centre_m)
    corners_m = shapely.get_coordinates(rough.base) - rough.centre_m
    irregular = _explanation(rough.base, cost_of(support_of(corners_m), reach), ground, base_m)
    shapes = [_explanation(base, cost, ground, base_m) for base, cost in _shapes(corners_m, rough.centre_m, reach)]
    good = [shape for shape in shapes if shape.uncovered < MOST_UNCOVERED and shape.total() < BETTER * irregular.total()]
    return _moved(rough, min(good, key=_Explanation.total).base) if good else None


def _shapes(corners_m: Array, origin_m: Array, reach: Reach) -> list[tuple[shapely.Polygon, float]]:
    """Return circle and rectangle, as far as they have a sensible size, with their costs, for a polygon with corners about the origin."""
    found = []
    circle, rectangle = fitted_circle(corners_m, reach), fitted_rectangle(corners_m, reach)
    if LEAST_RADIUS_M < circle.numbers[2] < MOST_RADIUS_M:
        centre = shapely.Point(origin_m + circle.numbers[:2])
        found.append((shapely.buffer(centre, circle.numbers[2], quad_segs=CORNERS_OF_QUARTER), circle.cost))
    half_m, turn_rad = rectangle.numbers[2:4], rectangle.numbers[4]
    if half_m.min() > LEAST_RADIUS_M and half_m.max() < MOST_RADIUS_M:
        turn = np.array([(np.cos(turn_rad), np.sin(turn_rad)), (-np.sin(turn_rad), np.cos(turn_rad))])
        found.append((shapely.Polygon(origin_m + rectangle.numbers[:2] + BOX * half_m @ turn), rectangle.cost))
    return found


def _explanation(base: shapely.Polygon, cost: float, ground: Ground, base_m: Array) -> _Explanation:
    return _Explanation(base, cost, _bare_share(base, ground), _uncovered_share(base, base_m))


def _bare_share(base: shapely.Polygon, ground: Ground) -> float:
    """Return how much, 0 to 1, of a footprint was seen bare."""
    left, low, right, high = base.bounds
    x_m, y_m = np.arange(left, right, SAMPLE_M), np.arange(low, high, SAMPLE_M)
    inside = shapely.contains_xy(base, *np.meshgrid(x_m, y_m))
    return float((ground.is_bare(x_m, y_m) & inside).sum() / max(int(inside.sum()), 1))


def _uncovered_share(base: shapely.Polygon, base_m: Array) -> float:
    """Return how much, 0 to 1, of a base line, (n, 2) [m; arena], does not lie in a footprint."""
    if not len(base_m):
        return 0.0
    return 1.0 - float(shapely.contains_xy(shapely.buffer(base, BASE_MARGIN_M, quad_segs=1), *base_m.T).mean())


def _moved(rough: Footprint, base: shapely.Polygon) -> Footprint:
    """Return a footprint with another base; how far single views are from its centre changes with that."""
    centre_m = shapely.get_coordinates(shapely.centroid(base))[0]
    moved_m = rough.centre_m - centre_m
    return Footprint(base, centre_m, rough.disagreement + np.outer(moved_m, moved_m))
