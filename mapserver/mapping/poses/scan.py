"""A local map as a scan: the base lines of what stands around the robot, as short pieces that each know which way they face.

An outline smears away from the eye; of all outlines in one direction only the nearest begins on the floor that is seen. What counts is what
the map holds for a thing that stands: robots, what moves, what lies flat and what one view alone takes for a thing are none.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray

from mapserver.mapping.bodies import Body
from mapserver.mapping.views.view import metres_per_rad
from protocol.geometry import Array, Pose2
from protocol.messages import LocalMap, Region

REACH_M = 0.9  # base lines are not told well beyond
EDGE_M = 0.05  # so near to the end of its sight a local map cuts things off
STEP_M = 0.01  # the longest piece of a base line
BIN_RAD = 0.02  # of direction, in which the nearest outline hides the others
HIDING_M = 0.02  # what lies so much farther than the nearest may be hidden
LEAST_FACING = 0.35  # cosine, of a piece's normal and the way to the eye: what is seen at a slant may be the side of a smear
LEAST_HEIGHT_M = 0.03  # what is lower may be paint, a joint or a cable
LEAST_PIECES = 4  # of a thing
MARGIN_M = 0.02  # around a footprint, besides what the robot's place may be wrong by
NEAR_SIGMA_M = 0.004  # of a base line straight below: shadow, gloss, the picture's edge ...
BASE_LINE_SIGMA_RAD = 0.005  # ... and of its direction, for a body that tilts a little; measured against the truth of arenas and recordings


class Scan(NamedTuple):
    """Pieces of the base lines around a robot."""

    points_m: Array  # (n, 2) middles [m; body]
    normals: Array  # (n, 2) of length 1, out of the things [body]
    sigmas_m: Array  # (n,) how well each is told, along its normal
    things: NDArray[np.intp]  # (n,) of which of the things that stand each is a piece

    def count_things(self) -> int:
        """Return of how many things there are pieces."""
        return len(np.unique(self.things))

    def still_standing(self, arena_from_body: Pose2, sigma_m: float, standing: Standing) -> Scan:
        """Return the pieces that lie, for a pose known to `sigma_m`, on what stands there now: what was pushed aside tells no place."""
        stands = standing.nearest(arena_from_body.apply(self.points_m), MARGIN_M + sigma_m) >= 0
        return Scan(self.points_m[stands], self.normals[stands], self.sigmas_m[stands], self.things[stands])


class Rough(NamedTuple):
    """What is known of where a thing stands."""

    corners_m: Array  # (n, 2) of its footprint [arena]
    height_m: float


class Standing:
    """The things that stand, for scans to be taken of them."""

    def __init__(self, things: Sequence[Rough]) -> None:
        """Take the things that are in the map."""
        tall = [thing.corners_m for thing in things if thing.height_m >= LEAST_HEIGHT_M]
        self._borders = shapely.STRtree([shapely.LinearRing(corners_m) for corners_m in tall])

    def nearest(self, points_m: Array, within_m: float) -> NDArray[np.intp]:
        """Return on the border of which thing points, (n, 2) [m; arena], lie, (n,), or within so much of it; -1: of none."""
        found = np.full(len(points_m), -1, np.intp)
        point, thing = self._borders.query_nearest(shapely.points(points_m), max_distance=within_m, all_matches=False)
        found[point] = thing
        return found


def scan_of(local_map: LocalMap, arena_from_body: Pose2, sigma_m: float, standing: Standing, bodies: Sequence[Body]) -> Scan:
    """Return the scan of a local map that was captured at a pose known to `sigma_m`, among the other robots' `bodies`."""
    borders = [_pieces(region) for region in local_map.regions]
    points_m, normals = (np.concatenate([np.empty((0, 2)), *parts]) for parts in (zip(*borders, strict=True) if borders else ((), ())))
    still = np.repeat([region.motion != "moving" for region in local_map.regions], [len(points) for points, _ in borders]).astype(np.bool_)
    ranges_m = np.hypot(*points_m.T)
    kept = still & (ranges_m < min(REACH_M, local_map.floor_range_m - EDGE_M)) & _is_nearest(points_m, ranges_m)
    kept &= -np.einsum("ij,ij->i", normals, points_m) > LEAST_FACING * ranges_m
    places_m = arena_from_body.apply(points_m)
    for body in bodies:
        kept &= np.hypot(*(places_m - body.position_m).T) > body.shadow_radius_m()
    things = np.full(len(points_m), -1, np.intp)
    things[kept] = standing.nearest(places_m[kept], MARGIN_M + sigma_m)
    kept = np.isin(things, np.flatnonzero(np.bincount(things[things >= 0]) >= LEAST_PIECES))
    across_m = BASE_LINE_SIGMA_RAD * np.array([metres_per_rad(float(each), local_map.camera_height_m) for each in ranges_m[kept]])
    return Scan(points_m[kept], normals[kept], np.hypot(NEAR_SIGMA_M, across_m), things[kept])


def _pieces(region: Region) -> tuple[Array, Array]:
    """Return the middles of the pieces of an outline, (n, 2) [m; body], and the way out of it, (n, 2) of length 1."""
    corners_m = region.outline.metres()
    edges_m = np.roll(corners_m, -1, axis=0) - corners_m
    lengths_m = np.hypot(*edges_m.T)
    counts = np.ceil(lengths_m / STEP_M).astype(np.int64)
    edge = np.repeat(np.arange(len(counts)), counts)
    share = (np.arange(len(edge)) - np.repeat(np.cumsum(counts) - counts, counts) + 0.5) / counts[edge]
    outward = np.column_stack([edges_m[:, 1], -edges_m[:, 0]])[edge] / lengths_m[edge, None]
    return corners_m[edge] + share[:, None] * edges_m[edge], outward


def _is_nearest(points_m: Array, ranges_m: Array) -> NDArray[np.bool_]:
    """Tell, (n,), which points on outlines, (n, 2) [m; body], have none nearer in their direction, nor just beside it."""
    count = round(2.0 * np.pi / BIN_RAD)
    bins = np.floor(np.arctan2(points_m[:, 1], points_m[:, 0]) / (2.0 * np.pi) * count).astype(np.int64) % count
    nearest_m = np.full(count, np.inf)
    np.minimum.at(nearest_m, bins, ranges_m)
    nearest_m = np.minimum(nearest_m, np.minimum(np.roll(nearest_m, 1), np.roll(nearest_m, -1)))
    return np.asarray(ranges_m < nearest_m[bins] + HIDING_M)
