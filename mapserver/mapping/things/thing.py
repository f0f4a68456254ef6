"""One thing that stands in the arena: the views that show it, its footprint and height, and how far it is believed in."""

from __future__ import annotations

import heapq
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
import shapely

from mapserver.mapping.belief import Belief
from mapserver.mapping.footprints.base_line import LEAST_BASE_CELLS, lies_beside, reaches_as_far
from mapserver.mapping.footprints.prism import Footprint, Ground, IsBare, footprint, whole_views
from mapserver.mapping.footprints.regular import regular
from mapserver.mapping.poses.scan import Rough
from mapserver.mapping.views.silhouette import SeenHeight, Silhouette, height_of
from mapserver.mapping.views.view import View
from protocol.fields import Packed
from protocol.geometry import Array
from protocol.messages import MapObject

DIRECTION_BINS, VIEWS_PER_BIN = 18, 3  # views kept: the best from each side
CLEARLY_BETTER = 1.1  # by so much more weight
MOST_HEIGHTS = 150  # the best resolved count
REFIT_NS = 190_000_000  # between two fits of what is in the map
COMPLETE_NS = 900_000_000  # between two fits of its circle or rectangle, which only people look at
LEAST_HEIGHT_M = 0.01  # what is told to be lower is a stain, a shadow or a sheet of paper, and robots drive over it
HEIGHT_STEP_M = 0.002  # a height that changes by less leaves the footprint as it is
LEAST_TOLD_SHARE, ENOUGH_TOLD = 0.2, 5  # of a thing's views tell its height, or so many do: what does so more seldom is a mixture ...
SURE_BELIEF = 1.0  # ... unless it is believed in so much
GAIN = 0.4  # of belief, for one clear view
MOST_BELIEF, SHOWN_BELIEF = 3.0, 0.3
DISTANT_GAIN = 0.1  # what even a distant view adds
MOST_MISSED_SHARE = 0.5  # of as many views as show a thing: what is missed more often is a piece of what looks like the floor, or none
MISFIT_SHARE, MISFIT_HEIGHT = 0.6, 0.75  # of the views that show a thing shorter than so much of the height told for it
BORDER_STEP_M = 0.02
LEAST_CENTRE_SIGMA_M = 0.003


class _Least(NamedTuple):
    """What a thing needs at least, to belong in the map."""

    views: int
    belief: float
    area_m2: float


WITH_BASE = _Least(3, SHOWN_BELIEF, 3e-4)
WITHOUT_BASE = _Least(6, SURE_BELIEF, 25e-4)  # with none on the map, a sliver is but a piece of something that looks like the floor
ALONE = 2  # times as many views are needed of what one robot alone has seen: it may be another robot that is not where it is believed to be


@dataclass(eq=False)
class Thing:
    """What is known of one thing; `number` tells it from all others."""

    number: int
    shape: Footprint
    anchor_m: Array  # (2,) on its base line, where it was last seen [arena]
    height_m: float | None
    seen_ns: int
    regular: Footprint | None = None  # a circle or rectangle, where it explains the views better than the shape does
    belief: float = 0.0
    observations: int = 0
    misses: int = 0  # views that should have shown it, and did not
    farthest_m: float = 0.0  # from where a view has shown it
    seen_by: set[str] = field(default_factory=set)
    views: list[Silhouette] = field(default_factory=list)  # that give the thing its shape
    heights: list[SeenHeight] = field(default_factory=list)  # that views told best
    base_m: Array = field(default_factory=lambda: np.empty((0, 2)))  # (n, 2) centres of the cells with its base line [arena]
    fitted_base_m: Array = field(default_factory=lambda: np.empty((0, 2)))  # (n, 2) the base line that the shape was fitted to [arena]
    fitted_ns: int = 0  # stamp of the newest view by then
    completed_ns: int = 0  # ... and when a circle or rectangle was last fitted
    is_stale: bool = False  # there are better views than those that the shape was fitted to, or another base line
    is_misfit: bool = False  # its views show it too short for its height, or it stands beside its base line

    def is_shown(self) -> bool:
        """Tell whether the thing belongs in the map."""
        least = WITH_BASE if len(self.base_m) >= LEAST_BASE_CELLS else WITHOUT_BASE
        least_views = least.views if len(self.seen_by) > 1 else ALONE * least.views
        rises = self.height_m is not None and self.height_m >= LEAST_HEIGHT_M
        known = rises and self.observations >= least_views and self.belief > least.belief
        told = self.belief > SURE_BELIEF or len(self.heights) >= min(LEAST_TOLD_SHARE * self.observations, ENOUGH_TOLD)
        stands = self.misses <= MOST_MISSED_SHARE * self.observations and not self.is_misfit
        return known and told and stands and self.shape.base.area > least.area_m2

    @property
    def standing(self) -> Footprint:
        """Where the thing stands in the map."""
        return self.regular or self.shape

    def is_due(self) -> bool:
        """Tell whether it is time to fit the shape anew: what is in the map rests for a while, however many views show it better."""
        return self.is_stale and not (self.is_shown() and self.seen_ns - self.fitted_ns < REFIT_NS)

    def border_m(self) -> Array:
        """Return points on the footprint's border, (n, 2) [m; arena], and where the thing's base line was last seen."""
        corners = shapely.get_coordinates(shapely.segmentize(self.shape.base, BORDER_STEP_M))
        return np.vstack([corners, self.anchor_m])

    def count(self, view: View, distance_m: float) -> None:
        """Believe in the thing the more, for a view that shows it."""
        self.belief = min(MOST_BELIEF, self.belief + GAIN * max(view.clarity(distance_m), DISTANT_GAIN))
        self.observations += 1
        self.farthest_m = max(self.farthest_m, distance_m)
        self.seen_by.add(view.robot)
        self.seen_ns = view.stamp_ns

    def miss(self, loss: float, distance_m: float) -> None:
        """Believe in the thing the less, by `loss`, for a view that should show it and does not.

        One from farther away than any that has shown it counts for nothing else: it may be too small to be seen from there.
        """
        self.belief -= loss
        self.misses += distance_m <= self.farthest_m

    def add(self, views: Sequence[Silhouette], heights: Sequence[SeenHeight]) -> None:
        """Keep those views that are among the best from their side; where that changes anything, the shape is stale."""
        best = _best_of_each_side(self.views, views, self.shape.centre_m)
        better = any(view not in self.views for view in best)
        self.views = best
        self.heights = heapq.nlargest(MOST_HEIGHTS, [*self.heights, *heights], key=lambda seen: seen.weight)
        height_m = height_of(self.heights)
        taller = height_m is not None and (self.height_m is None or abs(height_m - self.height_m) > HEIGHT_STEP_M)
        if better or taller:
            self.height_m, self.is_stale = height_m, True

    def stand_on(self, base_m: Array) -> None:
        """Take the cells with the thing's base line, (n, 2) [m; arena]; where that now reaches elsewhere, the shape is stale."""
        self.is_stale = self.is_stale or not reaches_as_far(base_m, self.fitted_base_m)
        self.base_m = base_m

    def fit(self, is_bare: IsBare, *, in_turn: bool = False) -> None:
        """Fit the footprint to the views and to the floor that is known by now to be bare; a circle or a rectangle now and then."""
        ground = Ground(is_bare, self.base_m)
        self.shape = footprint(self.views, self.height_m, ground) or self.shape
        if in_turn or self.seen_ns - self.completed_ns >= COMPLETE_NS:
            self.regular = None if self.height_m is None else regular(self.shape, self.views, self.height_m, ground)
            self.completed_ns = self.seen_ns
        self.fitted_base_m, self.fitted_ns = self.base_m, self.seen_ns
        self.is_misfit, self.is_stale = self._is_misfit(), False

    def _is_misfit(self) -> bool:
        """Tell whether the thing stands beside its base line, or most views, each the best from its side, show it too short for its height.

        A stretch of a wall that was taken for another thing keeps that one's base line until it has its own. What lies flat on the floor, a
        joint or paint, or a piece of something cut off by its look, has its height from what is near it.
        """
        height_m = MISFIT_HEIGHT * (self.height_m or 0.0)
        if lies_beside(self.base_m, self.shape.base):
            return True
        views, _ = whole_views(self.views, self.base_m)
        return sum(view.is_too_short_for(height_m) for view in views) > MISFIT_SHARE * len(views)

    def take_over(self, other: Thing) -> None:
        """Take all that is known of another thing, which was this one seen from elsewhere."""
        self.misses = self.misses if self.observations >= other.observations else other.misses
        self.farthest_m = max(self.farthest_m, other.farthest_m)
        self.belief, self.observations = max(self.belief, other.belief), max(self.observations, other.observations)
        self.seen_by |= other.seen_by
        self.anchor_m = self.anchor_m if self.seen_ns >= other.seen_ns else other.anchor_m
        self.seen_ns = max(self.seen_ns, other.seen_ns)
        self.add(other.views, other.heights)

    def rough(self) -> Rough:
        """Return the rough footprint: a circle or a rectangle is what the map shows, no evidence."""
        return Rough(shapely.get_coordinates(self.shape.base)[:-1], self.height_m or 0.0)

    def as_object(self, beliefs: Mapping[str, Belief]) -> MapObject:
        """Return the thing as it goes on the wire, with the robots' last `beliefs` for its uncertainty."""
        covariance = _centre_covariance(self.standing, [beliefs[robot] for robot in sorted(self.seen_by)])
        return MapObject(
            id=self.number,
            kind="obstacle",
            footprint=Packed.of(shapely.get_coordinates(shapely.orient_polygons(self.standing.base))[:-1], "f8"),
            height_m=self.height_m,
            seen_by=tuple(sorted(self.seen_by)),
            observations=self.observations,
            centre_covariance=(float(covariance[0, 0]), float(covariance[0, 1]), float(covariance[1, 1])),
        )


def _centre_covariance(standing: Footprint, observers: Sequence[Belief]) -> Array:
    """Return the covariance of a footprint's centre, (2, 2) [m^2; arena]: by how much views disagree, and the best observer's own."""
    placed = [observer.covariance_of_point(observer.arena_from_body.inverse().apply(standing.centre_m)) for observer in observers]
    return np.asarray(standing.disagreement + LEAST_CENTRE_SIGMA_M**2 * np.eye(2) + min(placed, key=np.trace))


def _best_of_each_side(kept: Sequence[Silhouette], new: Sequence[Silhouette], centre_m: Array) -> list[Silhouette]:
    """Return the views that resolve a thing best, of those from each side of the footprint's centre as many as are kept.

    A new view replaces one that is kept where it is clearly better, so that a robot that stands still changes nothing.
    """
    ranked = [(view.weight, view) for view in kept] + [(view.weight / CLEARLY_BETTER, view) for view in new]
    towards = np.array([view.eye_m for _, view in ranked]) - centre_m
    sides: defaultdict[int, list[tuple[float, Silhouette]]] = defaultdict(list)
    for side, item in zip(np.floor(np.arctan2(towards[:, 1], towards[:, 0]) / (2.0 * np.pi) * DIRECTION_BINS), ranked, strict=True):
        sides[int(side)].append(item)
    return [view for side in sorted(sides) for _, view in sorted(sides[side], key=lambda item: -item[0])[:VIEWS_PER_BIN]]
