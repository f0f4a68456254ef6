"""What stands in the arena: which region shows which thing, which things are one, and which are not believed in any more.

A thing is believed in the more often it is seen, and forgotten after a few clear views of bare floor where it should rise, so that what is
carried away leaves the map. Views that other robots cut off count for or against it, but not for its shape.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Mapping, Sequence

import numpy as np
import shapely
from numpy.typing import NDArray

from mapserver.mapping.belief import Belief
from mapserver.mapping.bodies import Body
from mapserver.mapping.prism import SeenHeight, Silhouette, footprint, silhouette_stretch, silhouettes_of
from mapserver.mapping.thing import Thing
from mapserver.mapping.view import StandingRegion, View, lay
from protocol.geometry import Array, Pose2
from protocol.messages import LocalMap, MapObject

MATCH_M = 0.06  # a region whose base line begins this near to a thing may show it
SHOWN_SHARE = 0.25  # of a thing's silhouette that regions must cover to show it ...
MISSED_SHARE = 0.08  # ... and below which it is missed
LOSS = 0.8  # of belief, for one clear view
FORGOTTEN_BELIEF = -0.5
EXPLAINED_SHARE, EXPLAINED_MARGIN_M = 0.7, 0.02  # of an outline within the silhouette of a known thing
SAME_SHARE = 0.4  # of the smaller footprint: with so much in common, two things are one
GUESS_NS = 30_000_000_000  # what is not in the map, and not seen again for so long, is forgotten
MOST_THINGS = 500


class ThingTracker:
    """Holds all things; `observe` local maps, `clear` where robots stand, then read the map's objects."""

    def __init__(self) -> None:
        """Start with nothing."""
        self._things: list[Thing] = []  # in the order of their numbers
        self._next_number = 0

    def observe(self, local_map: LocalMap, arena_from_body: Pose2, bodies: Sequence[Body]) -> None:
        """Take what one robot saw from `arena_from_body`, the other robots standing at `bodies`."""
        if local_map.picture == "dropped":
            return
        view = lay(local_map, arena_from_body, bodies)
        self._judge(view)
        shaped = [self._shape(region, view) for region in view.regions if view.shows_whole(region)]
        for thing in {item.number: item for item in shaped if item is not None}.values():
            if thing in self._things:  # not yet joined with another
                self._join(thing)
        self._forget(view.stamp_ns)

    def clear(self, bodies: Sequence[Body]) -> None:
        """Believe in nothing where robots stand."""
        for body in bodies:
            for thing in self._things:
                if math.dist(thing.shape.centre_m, body.position_m) < body.radius_m:
                    thing.belief = min(thing.belief, 0.0)

    def objects(self, beliefs: Mapping[str, Belief]) -> tuple[MapObject, ...]:
        """Return the things that are believed in, with the robots' present `beliefs` for their uncertainty."""
        return tuple(thing.as_object(beliefs) for thing in self._things if thing.is_shown())

    def _judge(self, view: View) -> None:
        """Believe more in the things that the view shows, and less in those it misses."""
        if not self._things:
            return
        distances_m = shapely.distance(_bases(self._things), shapely.Point(view.eye_m))
        silhouettes = _silhouettes(self._things, view.eye_m, view.eye_height_m)
        is_open = np.flatnonzero(view.is_open(silhouettes, distances_m))
        for index, share in zip(is_open.tolist(), _shown_shares(silhouettes[is_open], view), strict=True):
            thing, distance_m = self._things[index], float(distances_m[index])
            if share > SHOWN_SHARE:
                thing.count(view, distance_m)
            elif share < MISSED_SHARE:
                thing.belief -= LOSS * view.clarity(distance_m)

    def _shape(self, region: StandingRegion, view: View) -> Thing | None:
        """Give a region to the thing it shows, or to a new one, and return that where its shape changed."""
        heights = [height] if (height := view.seen_height(region)) is not None else []
        thing = self._shown_by(region)
        if thing is not None:
            return thing if thing.add([view.silhouette(region)], heights) else None
        if view.clarity(region.distance_m) <= 0.0:
            return None
        owner = _explainer([thing for thing in self._things if thing.height_m is not None], view.silhouette(region))
        if owner is not None:
            return owner if owner.add([view.silhouette(region)], heights) else None
        return self._begin(region, view, heights)

    def _shown_by(self, region: StandingRegion) -> Thing | None:
        """Return the thing that most of lies within a region, of those that its base line begins at."""
        if not self._things:
            return None
        is_near = shapely.dwithin(_bases(self._things), shapely.Point(region.nearest_m), MATCH_M)
        near = [self._things[index] for index in np.flatnonzero(is_near)]
        if len(near) == 1:
            return near[0]
        return max(near, key=lambda thing: _share_inside(thing.shape.base, region.outline), default=None)

    def _begin(self, region: StandingRegion, view: View, heights: Sequence[SeenHeight]) -> Thing | None:
        """Hold that a region shows a thing not known before."""
        silhouette = view.silhouette(region)
        if (shape := footprint([silhouette], None)) is None:
            return None
        thing = Thing(self._next_number, shape, None, view.stamp_ns, views=[silhouette])
        thing.count(view, region.distance_m)
        thing.heights.extend(heights)
        self._next_number += 1
        self._things.append(thing)
        return thing

    def _join(self, thing: Thing) -> None:
        """Join a thing that changed with another on the same floor, and drop those that it turns out to explain."""
        near = np.flatnonzero(shapely.intersects(_bases(self._things), thing.shape.base)).tolist()
        others = (self._things[index] for index in near if self._things[index] is not thing)
        twin = next((other for other in others if _is_same(thing.shape.base, other.shape.base)), None)
        if twin is not None:
            thing, newer = sorted((thing, twin), key=lambda item: item.number)
            thing.take_over(newer)
            self._things.remove(newer)
        if thing.height_m is not None:
            self._things = [other for other in self._things if not _is_ghost(other, thing)]

    def _forget(self, stamp_ns: int) -> None:
        """Forget what is not believed in, what stayed a guess, and, of too much, the least believed."""
        kept = [thing for thing in self._things if thing.belief > FORGOTTEN_BELIEF]
        kept = [thing for thing in kept if thing.is_shown() or stamp_ns - thing.seen_ns < GUESS_NS]
        best = heapq.nlargest(MOST_THINGS, kept, key=lambda thing: thing.belief)
        self._things = sorted(best, key=lambda thing: thing.number)


def _bases(things: Sequence[Thing]) -> list[shapely.Polygon]:
    return [thing.shape.base for thing in things]


def _silhouettes(things: Sequence[Thing], eye_m: Array, eye_height_m: float) -> NDArray[np.object_]:
    """Return what things cover on the floor, polygons (n,), from an eye; those of unknown height their bases."""
    heights_m = np.array([thing.height_m or 0.0 for thing in things])
    return silhouettes_of(_bases(things), heights_m, eye_m, eye_height_m)


def _shown_shares(silhouettes: NDArray[np.object_], view: View) -> Array:
    """Return how much, (n,) 0 to 1, of each silhouette, (n,), the regions of a view cover."""
    outlines = np.array([region.outline for region in view.regions], dtype=np.object_)
    index, touched = shapely.STRtree(outlines).query(silhouettes)
    common_m2 = np.zeros(len(silhouettes))
    for number in np.unique(index):
        near = outlines[touched[index == number]]
        common_m2[number] = shapely.area(shapely.intersection(silhouettes[number], near[0] if len(near) == 1 else shapely.union_all(near)))
    return np.asarray(common_m2 / shapely.area(silhouettes))


def _share_inside(base: shapely.Polygon, outline: shapely.Polygon) -> float:
    return float(base.intersection(outline).area / base.area)


def _is_ghost(thing: Thing, known: Thing) -> bool:
    """Tell whether all views of a thing of unknown height show but the upper part of a known one."""
    return thing.height_m is None and all(_explainer([known], view) is not None for view in thing.views)


def _explainer(things: Sequence[Thing], seen: Silhouette) -> Thing | None:
    """Return the first of things of known height of which an outline is but the upper part, the base blending into the floor."""
    things = [thing for thing in things if _may_cover(thing, seen)]
    if not things:
        return None
    silhouettes = _silhouettes(things, seen.eye_m, seen.eye_height_m)
    near = np.flatnonzero(shapely.dwithin(silhouettes, seen.outline, EXPLAINED_MARGIN_M))
    common = shapely.intersection(shapely.buffer(silhouettes[near], EXPLAINED_MARGIN_M, quad_segs=2), seen.outline)
    explaining = near[shapely.area(common) > EXPLAINED_SHARE * seen.outline.area]
    return things[int(explaining[0])] if len(explaining) else None


def _may_cover(thing: Thing, seen: Silhouette) -> bool:
    """Tell whether the box around what a thing covers, seen from the eye of a view, reaches to within the margin of its outline."""
    base = np.array(thing.shape.base.bounds).reshape(2, 2)
    top = seen.eye_m + silhouette_stretch(thing.height_m or 0.0, seen.eye_height_m) * (base - seen.eye_m)
    low, high = np.minimum(base[0], top[0]) - EXPLAINED_MARGIN_M, np.maximum(base[1], top[1]) + EXPLAINED_MARGIN_M
    return bool((low <= seen.highest_m).all() and (high >= seen.lowest_m).all())


def _is_same(first: shapely.Polygon, second: shapely.Polygon) -> bool:
    """Tell whether two footprints have so much of the smaller in common that they are of one thing."""
    return bool(first.intersection(second).area > SAME_SHARE * min(first.area, second.area))
