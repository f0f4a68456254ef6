"""What stands in the arena: which region shows which thing, which things are one, and which are not believed in any more.

A region shows the thing on whose base its near border lies: the cells with a base that no bare floor parts are of one thing (clusters.py).
A thing is believed in the more often it is seen, and forgotten after a few clear views of bare floor where it should rise, so that what is
carried away leaves the map. What cuts off a view, another robot or a nearer thing, makes it count neither way.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Sequence
from typing import Protocol

import numpy as np
import shapely
from numpy.typing import NDArray

from mapserver.mapping.bodies import Body
from mapserver.mapping.floor.clusters import Clusters
from mapserver.mapping.footprints.prism import footprint
from mapserver.mapping.things.pieces import wholes
from mapserver.mapping.things.thing import Thing
from mapserver.mapping.views.silhouette import Silhouette, silhouettes_of
from mapserver.mapping.views.view import StandingRegion, View, lay, metres_per_rad
from protocol.geometry import Array, Pose2
from protocol.messages import LocalMap

MATCH_M, MATCH_RAD = 0.06, 0.01  # a region whose base line begins so near to a thing shows it; the angle is a few pixels
MISSED_SHARE = 0.08  # of a thing's silhouette: where regions cover less of it, it is missed
LOSS = 0.8  # of belief, for one clear view
FORGOTTEN_BELIEF = -0.5
SAME_SHARE, SAME_MARGIN_M = 0.4, 0.03  # with so much of the smaller footprint, grown by a margin, in common, two things are one
EXPLAINED_SHARE, EXPLAINED_MARGIN_M = 0.7, 0.02  # of an outline within the silhouette of a known thing, which is ...
EXPLAINED_REACH_M = 1.0  # ... no farther from it than this
GUESS_NS = 30_000_000_000  # what is not in the map, and not seen again for so long, is forgotten
MOST_THINGS = 500
NEAR_BORDER_M = 0.03  # of a region: all of its border that is at most so much farther than the nearest point


class KnownFloor(Protocol):
    """What is known of the floor by now."""

    def is_bare(self, x_m: Array, y_m: Array) -> NDArray[np.bool_]:
        """Tell, (rows, columns), where bare floor was seen, at x (columns,) and y (rows,), both growing [m; arena]."""
        ...

    def clusters(self, centre_m: Array, radius_m: float) -> Clusters:
        """Return the clusters of base cells around a centre, (2,) [m; arena]."""
        ...


class ThingTracker:
    """Holds all things; `observe` local maps, `clear` where robots stand, `fit`, then read what is `shown`."""

    def __init__(self, floor: KnownFloor) -> None:
        """Start with nothing; `floor` is asked for what is known when it is asked."""
        self._floor = floor
        self._things: list[Thing] = []  # in the order of their numbers
        self._unfitted: list[Thing] = []  # since more floor may be known to be bare
        self._next_number = 0

    def observe(self, local_map: LocalMap, arena_from_body: Pose2, bodies: Sequence[Body]) -> list[Array]:
        """Take what one robot saw from `arena_from_body`, the other robots standing at `bodies`.

        Return the footprints, (n, 2) [m; arena] each, of the things that are believed in and that this view has missed: the bare floor that
        it shows there is no floor yet.
        """
        if local_map.picture == "dropped":
            return []
        view = lay(local_map, arena_from_body, bodies)
        shown = self._assign(view, self._floor.clusters(view.eye_m, view.range_m))
        for thing, distance_m in shown.values():
            thing.count(view, distance_m)
        missed = self._missed(view, set(shown))
        for thing in missed:
            distance_m = math.dist(thing.anchor_m, view.eye_m)
            thing.miss(LOSS * view.clarity(distance_m), distance_m)
        for thing, _ in shown.values():
            self._join(thing)
        self._forget(view.stamp_ns)
        return [shapely.get_coordinates(thing.shape.base) for thing in missed if thing.is_shown()]

    def _assign(self, view: View, clusters: Clusters) -> dict[int, tuple[Thing, float]]:
        """Give every region that shows a thing whole to that, or to a new one; return those things by number, with their distance [m]."""
        on_cluster = self._on_clusters(clusters)
        shown: dict[int, tuple[Thing, float]] = {}
        for region in view.regions:
            if not view.shows_whole(region):
                continue
            cluster = _cluster_of(region, view.eye_m, clusters)
            thing = (on_cluster.get(cluster) if cluster else self._nearest(region, view)) or self._begin(region, view)
            if thing is not None:
                if cluster:
                    on_cluster[cluster] = thing
                self._shape(thing, region, view)
                shown[thing.number] = thing, min(region.distance_m, shown.get(thing.number, (thing, math.inf))[1])
        return shown

    def _nearest(self, region: StandingRegion, view: View) -> Thing | None:
        """Return the thing on whose footprint a region's base line begins, or nearly so."""
        if not self._things:
            return None
        away_m = shapely.distance(_bases(self._things), shapely.Point(region.nearest_m))
        nearest = int(np.argmin(away_m))
        near_m = MATCH_M + MATCH_RAD * metres_per_rad(region.distance_m, view.eye_height_m)
        return self._things[nearest] if away_m[nearest] < near_m else None

    def _missed(self, view: View, shown: set[int]) -> list[Thing]:
        """Return the things that a view should show, and does not."""
        expected = [thing for thing in self._things if thing.number not in shown]
        if not expected:
            return []
        silhouettes = _silhouettes(expected, view.eye_m, view.eye_height_m)
        distances_m = shapely.distance(_bases(expected), shapely.Point(view.eye_m))
        is_open = np.flatnonzero(view.is_open(silhouettes, distances_m))
        shares = _shown_shares(silhouettes[is_open], view)
        return [expected[index] for index, share in zip(is_open.tolist(), shares, strict=True) if share < MISSED_SHARE]

    def clear(self, bodies: Sequence[Body]) -> None:
        """Believe in nothing where robots stand."""
        for body in bodies:
            for thing in self._things:
                if math.dist(thing.shape.centre_m, body.position_m) < body.radius_m:
                    thing.belief = min(thing.belief, 0.0)

    def fit(self) -> None:
        """Fit the things that were seen better since, those in the map now and then, and one more in its turn.

        By now floor beside that one may have been seen bare.
        """
        in_turn = self._next_in_turn()
        for thing in self._things:
            if thing.is_due() or thing is in_turn:
                thing.fit(self._floor.is_bare, in_turn=thing is in_turn)

    def shown(self) -> list[Thing]:
        """Return the things that are believed in, pieces put together."""
        return wholes([thing for thing in self._things if thing.is_shown()])

    def _on_clusters(self, clusters: Clusters) -> dict[int, Thing]:
        """Return the thing on each cluster in sight that has one; things on one cluster are joined."""
        found: dict[int, Thing] = {}
        for thing in list(self._things):
            cluster = clusters.most_at(thing.border_m())
            if cluster in found:
                self._take_over(found[cluster], thing)
            elif cluster:
                found[cluster] = thing
                thing.stand_on(clusters.cells_of(cluster))
        return found

    def _begin(self, region: StandingRegion, view: View) -> Thing | None:
        """Hold that a region shows a thing not known before; None where it is too far away, or a known thing explains it."""
        silhouette = view.silhouette(region)
        if view.clarity(region.distance_m) <= 0.0 or self._explains(silhouette) or (shape := footprint([silhouette], None)) is None:
            return None
        thing = Thing(self._next_number, shape, region.nearest_m, None, view.stamp_ns)
        self._next_number += 1
        self._things.append(thing)
        return thing

    def _explains(self, seen: Silhouette) -> bool:
        """Tell whether an outline is but the upper part of a known thing, the base blending into the floor."""
        near = [thing for thing in self._things if thing.is_shown() and shapely.dwithin(thing.shape.base, seen.outline, EXPLAINED_REACH_M)]
        if not near:
            return False
        covered = shapely.buffer(_silhouettes(near, seen.eye_m, seen.eye_height_m), EXPLAINED_MARGIN_M, quad_segs=2)
        return bool((shapely.area(shapely.intersection(covered, seen.outline)) > EXPLAINED_SHARE * seen.outline.area).any())

    def _shape(self, thing: Thing, region: StandingRegion, view: View) -> None:
        silhouette = view.silhouette(region)
        heights = [height] if (height := view.seen_height(region, silhouette)) is not None else []
        thing.anchor_m = region.nearest_m
        thing.add([silhouette], heights)

    def _join(self, thing: Thing) -> None:
        """Join a thing with another on the same floor."""
        if thing not in self._things:  # joined already
            return
        for index in np.flatnonzero(shapely.dwithin(_bases(self._things), thing.shape.base, SAME_MARGIN_M)).tolist():
            other = self._things[index]
            if other is not thing and _is_same(thing.shape.base, other.shape.base):
                self._take_over(*sorted((thing, other), key=lambda item: item.number))
                return

    def _take_over(self, thing: Thing, newer: Thing) -> None:
        thing.take_over(newer)
        self._things.remove(newer)

    def _next_in_turn(self) -> Thing | None:
        """Return the next thing of a round through all; None between two rounds."""
        while self._unfitted:
            thing = self._unfitted.pop()
            if thing in self._things:
                return thing
        self._unfitted = list(self._things)
        return None

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


def _cluster_of(region: StandingRegion, eye_m: Array, clusters: Clusters) -> int:
    """Return the cluster on which most of a region's near border lies; 0 where it lies on none."""
    corners = shapely.get_coordinates(region.outline)
    return clusters.most_at(corners[np.hypot(*(corners - eye_m).T) < region.distance_m + NEAR_BORDER_M])


def _is_same(first: shapely.Polygon, second: shapely.Polygon) -> bool:
    """Tell whether two footprints have so much of the smaller in common that they are of one thing."""
    smaller, larger = sorted((first, second), key=lambda base: base.area)
    return bool(smaller.buffer(SAME_MARGIN_M, quad_segs=2).intersection(larger).area > SAME_SHARE * smaller.area)
