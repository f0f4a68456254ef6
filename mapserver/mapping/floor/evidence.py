"""What one local map says about the cells around the robot: bare floor, the base of something that stands there, or nothing.

The outline of a region smears away from the camera by the thing's height, so its border that faces the robot is a true
base line, and all behind it may be floor that this view could not see.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from mapserver.mapping.bodies import Body, robot_sector
from mapserver.mapping.floor.grid import CELL_M, Window, window_around
from mapserver.mapping.floor.raster import SHIFT_BITS, Corners, corners_of, fill
from mapserver.mapping.views.view import MAX_RANGE_M, metres_per_rad
from protocol.geometry import Array, Pose2
from protocol.messages import LocalMap, Region

NOTHING, FLOOR, BASE = range(3)

BASE_DEPTH_M = 0.04  # behind the base line an object goes on for at least this far, cables apart
BASE_LINE_SIGMA_RAD = 0.002  # a base line lies in the picture to about a pixel
CONVEX_SHARE = 0.98  # of its hull, that an outline has at least which was drawn as one
_RESOLUTION_BLOCK = 8  # cells: it varies slowly

Labels = NDArray[np.uint8]


class _Shape(NamedTuple):
    """One region as cv2 fixed-point polygons, shape (n, 2): its outline, and copies scaled about the eye."""

    outline: Corners
    behind_base: Corners
    before_base: Corners
    stands: bool


class Evidence(NamedTuple):
    """Labels NOTHING, FLOOR or BASE, one a cell, shape `window.shape`."""

    window: Window
    labels: Labels


def evidence_of(local_map: LocalMap, arena_from_body: Pose2, bodies: Sequence[Body], missed: Sequence[Array] = ()) -> Evidence:
    """Label the cells within the local map's floor range, seen from `arena_from_body`, among the other robots' `bodies`.

    What hides behind things and other robots, what moves, the own body, and the footprints, (n, 2) [m; arena] each, of things that the view
    has `missed` are labelled NOTHING.
    """
    eye_m = np.array(arena_from_body[:2])
    range_m = min(local_map.floor_range_m, MAX_RANGE_M)
    window = window_around(eye_m, range_m)
    sectors = [_to_cells(sector, window) for body in bodies if (sector := robot_sector(eye_m, body, 2.0 * range_m)) is not None]
    untold = [_to_cells(footprint_m, window) for footprint_m in missed]
    hidden = _filled(window, sectors + untold) | _disc(window, eye_m, local_map.body_radius_m)
    labels = _disc(window, eye_m, range_m)  # FLOOR, until something stands there
    _paint_regions(labels, [_shape(region, local_map, arena_from_body, window, bodies) for region in local_map.regions])
    labels *= hidden == 0
    return Evidence(window, labels)


def resolution(window: Window, eye_m: Array, camera_height_m: float) -> NDArray[np.float32]:
    """Return by how much fewer pixels each cell covers than one at twice the camera's height away; 1 for all that are nearer.

    A small piece of floor at distance r spans a solid angle in proportion to h / (h^2 + r^2)^(3/2).
    """
    squared_m2 = window.squared_distances_m2(eye_m, every=_RESOLUTION_BLOCK) + np.float32(camera_height_m**2)
    ratio = np.float32(5.0 * camera_height_m**2) / squared_m2
    coarse = np.minimum(ratio * np.sqrt(ratio), np.float32(1.0))
    return np.asarray(cv2.resize(coarse, window.shape[::-1], interpolation=cv2.INTER_NEAREST), dtype=np.float32)


def _paint_regions(labels: Labels, shapes: Sequence[_Shape]) -> None:
    """Paint regions over the floor: a base where they stand, and nothing behind it, nor in the cells that a border runs through."""
    within_reach = labels > 0
    for shape in shapes:
        fill(labels, shape.before_base, NOTHING)
        fill(labels, shape.outline, NOTHING)
    behind = np.zeros_like(labels)
    for shape in shapes:
        if shape.stands:
            fill(labels, shape.outline, BASE)
            fill(behind, shape.behind_base, 1)
    cv2.polylines(labels, [shape.outline for shape in shapes], True, NOTHING, lineType=cv2.LINE_8, shift=SHIFT_BITS)
    labels *= within_reach & ((labels != BASE) | (behind == 0))


def _shape(region: Region, local_map: LocalMap, arena_from_body: Pose2, window: Window, bodies: Sequence[Body]) -> _Shape:
    """Return a region's outline and what follows from it, as polygons in the window.

    A convex region that takes in a robot as well is the hull of both, and its near border no base line.
    """
    eye_m = np.array(arena_from_body[:2])
    outline_m = arena_from_body.apply(region.outline.metres())
    nearest_m = max(float(np.min(np.hypot(*(outline_m - eye_m).T))), CELL_M)
    further, nearer = nearest_m + BASE_DEPTH_M, max(nearest_m - _base_line_sigma(nearest_m, local_map.camera_height_m), 0.0)
    scales = np.array([nearest_m, further, nearer]) / nearest_m
    outline, behind, before = _to_cells(eye_m + scales[:, None, None] * (outline_m - eye_m), window)
    stands = region.motion != "moving" and not _is_hull_with_robot(outline_m, bodies)
    return _Shape(outline, behind, before, stands)


def _is_hull_with_robot(outline_m: Array, bodies: Sequence[Body]) -> bool:
    outline = outline_m.astype(np.float32)
    is_convex = cv2.contourArea(outline) > CONVEX_SHARE * cv2.contourArea(cv2.convexHull(outline))
    places_m = ((float(x_m), float(y_m)) for x_m, y_m in (body.position_m for body in bodies))
    return is_convex and any(cv2.pointPolygonTest(outline, place_m, False) >= 0.0 for place_m in places_m)


def _base_line_sigma(distance_m: float, camera_height_m: float) -> float:
    """Return how well a base line's distance is known [m]."""
    return BASE_LINE_SIGMA_RAD * metres_per_rad(distance_m, camera_height_m)


def _to_cells(points_m: Array, window: Window) -> Corners:
    return corners_of(points_m, window.origin_m, CELL_M)


def _filled(window: Window, polygons: Sequence[Corners]) -> Labels:
    mask = np.zeros(window.shape, dtype=np.uint8)
    for polygon in polygons:
        fill(mask, polygon, 1)
    return mask


def _disc(window: Window, centre_m: Array, radius_m: float) -> Labels:
    mask = np.zeros(window.shape, dtype=np.uint8)
    centre = _to_cells(centre_m, window)
    radius = round(radius_m / CELL_M * (1 << SHIFT_BITS))
    cv2.circle(mask, (int(centre[0]), int(centre[1])), radius, 1, thickness=cv2.FILLED, lineType=cv2.LINE_8, shift=SHIFT_BITS)
    return mask
