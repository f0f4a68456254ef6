"""One local map laid into the arena: the regions it shows, what it cannot tell, and how well it resolves."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray

from mapserver.mapping.bodies import Body, robot_sector
from mapserver.mapping.views.silhouette import SeenHeight, Silhouette
from mapserver.mapping.views.stretches import stretches_of
from protocol.geometry import Array, Pose2
from protocol.messages import LocalMap

MAX_RANGE_M = 3.3  # no packed outline reaches further
CLEAR_REACH_IN_HEIGHTS = 3.0  # beyond this a missing thing may just be too small to be told from the floor
TOUCHING_M = 0.01
MOST_COVERED = 0.5  # of a region's width, from the eye, that a nearer one may hide
TOUCHED_WEIGHT = 0.1  # of the height of a region that touches a nearer one
MOST_CLOSED = 0.3  # of a silhouette that may be hidden where the rest still tells


class StandingRegion(NamedTuple):
    """What one view shows of something that stands still."""

    outline: shapely.Polygon  # without holes [arena]
    nearest_m: Array  # (2,) where its base line comes nearest to the eye [arena]
    distance_m: float  # of that point from the eye
    height_m: float | None  # of its top, where the view has told it
    touches: bool = False  # another region, which is nearer
    covered: bool = False  # its base line, or most of it, lies behind that


@dataclass(frozen=True, eq=False)
class View:
    """What one robot saw at one moment."""

    robot: str
    stamp_ns: int
    eye_m: Array  # (2,) point under the camera [arena]
    eye_height_m: float
    range_m: float
    body_range_m: float  # nearer than this the robot sees itself
    hidden: shapely.Geometry  # behind other robots [arena]
    closed: shapely.Geometry  # where the view says nothing: hidden, or moving [arena]
    regions: tuple[StandingRegion, ...]

    def clarity(self, distance_m: float) -> float:
        """Return how surely a thing at this distance would be seen, 0 to 1."""
        return max(0.0, 1.0 - (distance_m / (CLEAR_REACH_IN_HEIGHTS * self.eye_height_m)) ** 2)

    def weight(self, distance_m: float) -> float:
        """Return how well a thing at this distance is resolved: a pixel's length on the floor, squared and inverted."""
        return 1.0 / (1.0 + (distance_m / self.eye_height_m) ** 2) ** 2

    def shows_whole(self, region: StandingRegion) -> bool:
        """Tell whether no other robot, nor a nearer thing, cuts off a region. Where the reach does, its base line is still whole."""
        return not region.covered and not region.outline.intersects(self.hidden)

    def is_open(self, silhouettes: NDArray[np.object_], distances_m: Array) -> NDArray[np.bool_]:
        """Tell of each silhouette, (n,), its base at a distance, (n,), whether it would be seen: within reach, and mostly unhidden."""
        within = np.asarray((distances_m < self.range_m) & (distances_m >= self.body_range_m))
        hidden_m2 = shapely.area(shapely.intersection(silhouettes[within], self.closed))
        within[within] = hidden_m2 < MOST_CLOSED * shapely.area(silhouettes[within])
        return within

    def silhouette(self, region: StandingRegion) -> Silhouette:
        """Return the region as a view of one thing."""
        return Silhouette(self.eye_m, self.eye_height_m, region.outline, self.weight(region.distance_m))

    def seen_height(self, region: StandingRegion, silhouette: Silhouette) -> SeenHeight | None:
        """Return the region's height with the weight of its silhouette, the more of the thing's width it shows; None where it told none.

        A height that no top in sight can have is none; that of a region which touches a nearer one may be that one's.
        """
        if region.height_m is None or not 0.0 < region.height_m < self.eye_height_m:
            return None
        weight = TOUCHED_WEIGHT if region.touches else 1.0
        return SeenHeight(region.height_m, weight * silhouette.weight * silhouette.extent.width_m)


def metres_per_rad(distance_m: float, eye_height_m: float) -> float:
    """Return how far apart on the floor, along the line of sight, directions a radian apart meet it: (h^2 + r^2) / h, by tan(a) = r / h."""
    return (eye_height_m**2 + distance_m**2) / eye_height_m


def lay(local_map: LocalMap, arena_from_body: Pose2, bodies: Sequence[Body]) -> View:
    """Return what a robot at `arena_from_body` sees among the other robots' `bodies`."""
    eye_m = np.array(arena_from_body[:2])
    range_m = min(local_map.floor_range_m, MAX_RANGE_M)
    sectors = [robot_sector(eye_m, body, 2.0 * range_m) for body in bodies]
    hidden = shapely.union_all([shapely.Polygon(sector) for sector in sectors if sector is not None])
    outlines = _polygons([arena_from_body.apply(region.outline.metres()) for region in local_map.regions])
    laid = [(region, outline) for region, outline in zip(local_map.regions, outlines, strict=True) if outline is not None]
    moving = [outline for region, outline in laid if region.motion == "moving"]
    standing = [
        (stretch, region.height_m) for region, outline in laid if region.motion != "moving" for stretch in stretches_of(outline, eye_m)
    ]
    return View(
        robot=local_map.robot,
        stamp_ns=local_map.stamp_ns,
        eye_m=eye_m,
        eye_height_m=local_map.camera_height_m,
        range_m=range_m,
        body_range_m=local_map.body_radius_m,
        hidden=hidden,
        closed=shapely.union_all([hidden, *moving]) if moving else hidden,
        regions=tuple(_with_covered([_standing(outline, height_m, eye_m) for outline, height_m in standing], eye_m)),
    )


def _standing(outline: shapely.Polygon, height_m: float | None, eye_m: Array) -> StandingRegion:
    corners = shapely.get_coordinates(outline)
    distances_m = np.hypot(*(corners - eye_m).T)
    nearest = int(np.argmin(distances_m))
    return StandingRegion(outline, corners[nearest], float(distances_m[nearest]), height_m)


def _with_covered(regions: Sequence[StandingRegion], eye_m: Array) -> list[StandingRegion]:
    """Return the regions, with those marked that touch a nearer one, and those whose base line is lost behind it."""
    touching = _touching(regions)
    touches = set(touching[:, 1].tolist())
    covered = {behind for front, behind in touching if _covers(regions[front], regions[behind], eye_m)}
    return [region._replace(touches=index in touches, covered=index in covered) for index, region in enumerate(regions)]


def _touching(regions: Sequence[StandingRegion]) -> NDArray[np.int_]:
    """Return which regions touch another one that is farther from the eye, (n, 2), the nearer one first."""
    distances_m = np.array([region.distance_m for region in regions])
    pairs = np.argwhere(distances_m[:, None] < distances_m)
    outlines = np.array([region.outline for region in regions], dtype=np.object_)
    return np.asarray(pairs[shapely.distance(outlines[pairs[:, 0]], outlines[pairs[:, 1]]) <= TOUCHING_M])


def _covers(front: StandingRegion, behind: StandingRegion, eye_m: Array) -> bool:
    """Tell whether a region takes up most of the width of another, which stands behind it."""
    (first, last), (left, right) = _span(behind.outline, eye_m, behind.nearest_m), _span(front.outline, eye_m, behind.nearest_m)
    return min(last, right) - max(first, left) > MOST_COVERED * (last - first)


def _span(outline: shapely.Polygon, eye_m: Array, towards_m: Array) -> tuple[float, float]:
    """Return the least and the greatest bearing [rad] of an outline from the eye, counted from the direction of a point."""
    offsets = shapely.get_coordinates(outline) - eye_m
    middle = math.atan2(towards_m[1] - eye_m[1], towards_m[0] - eye_m[0])
    turns = np.angle(np.exp(1j * (np.arctan2(offsets[:, 1], offsets[:, 0]) - middle)))
    return float(turns.min()), float(turns.max())


def _polygons(outlines: Sequence[Array]) -> list[shapely.Polygon | None]:
    """Return outlines, (n, 2) each, as polygons, mended where they cross themselves; None where nothing of one is left."""
    if not outlines:
        return []
    owners = np.repeat(np.arange(len(outlines)), [len(outline) for outline in outlines])
    polygons = shapely.polygons(shapely.linearrings(np.concatenate(outlines), indices=owners))
    for index in np.flatnonzero(~shapely.is_valid(polygons)):
        polygons[index] = _mended(polygons[index])
    usable = shapely.is_valid(polygons) & (shapely.area(polygons) > 0.0)
    return [polygon if good else None for polygon, good in zip(polygons, usable, strict=True)]


def _mended(outline: shapely.Polygon) -> shapely.Polygon:
    """Return the largest part of an outline that crosses itself."""
    parts = [part for part in shapely.get_parts(shapely.make_valid(outline)) if isinstance(part, shapely.Polygon)]
    return shapely.Polygon(max(parts, key=shapely.area).exterior) if parts else outline
