"""A camera that looks straight down from half a metre, and convex upright things as it sees them on the floor."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from agent.slam.feature_tracks import Tracks, begin, observe
from agent.vision.floor_projection import FloorProjection
from agent.vision.floor_view import make_floor_view
from agent.vision.hull import convex_hull
from agent.vision.lens import KannalaBrandt
from protocol.geometry import Array

HEIGHT_M = 0.5
POSE = np.array([[0.0, -1.0, 0.0, 0.0], [-1.0, 0.0, 0.0, 0.0], [0.0, 0.0, -1.0, HEIGHT_M], [0.0, 0.0, 0.0, 1.0]])
PROJECTION = FloorProjection(KannalaBrandt(200.0, 200.0, 319.5, 319.5), POSE)
VIEW = make_floor_view(PROJECTION, (640, 640), body_radius_m=0.08, body_height_m=0.1)
SIGMA_M = 0.001
WAY_M = np.stack([np.linspace(-0.2, 0.0, 11), np.zeros(11)], axis=-1)  # of the camera, up to where it is now


def appearances(points: ArrayLike, eye_m: ArrayLike = (0.0, 0.0)) -> Array:
    """Return where points (n, 3) [m] appear on the floor, (n, 2), to a camera at `eye_m` (2,)."""
    places, height = np.hsplit(np.asarray(points, dtype=np.float64), [2])
    stretch = HEIGHT_M / (HEIGHT_M - height)
    return np.asarray(stretch * places + (1.0 - stretch) * np.asarray(eye_m))


def upright(footprint: ArrayLike, height_m: float) -> Array:
    """Return the corners, (2 n, 3) [m], of an upright thing: its footprint (n, 2) on the floor, and again at its top."""
    base = np.asarray(footprint, dtype=np.float64)
    return np.concatenate([np.insert(base, 2, 0.0, axis=1), np.insert(base, 2, height_m, axis=1)])


def box(near_m: float, far_m: float, half_width_m: float) -> Array:
    """Return the footprint, (4, 2) [m], of a box ahead."""
    return np.array([(near_m, -half_width_m), (far_m, -half_width_m), (far_m, half_width_m), (near_m, half_width_m)])


def disc(x_m: float, y_m: float, radius_m: float) -> Array:
    """Return the footprint, (90, 2) [m], of a round thing."""
    turn = np.linspace(0.0, 2.0 * np.pi, 90, endpoint=False)
    return np.stack([x_m + radius_m * np.cos(turn), y_m + radius_m * np.sin(turn)], axis=-1)


def seen(points: ArrayLike) -> NDArray[np.uint8]:
    """Return the mask of the view that a convex thing with these corners, (n, 3) [m], covers."""
    hull = convex_hull(appearances(points))
    candidates = np.flatnonzero(VIEW.valid)
    range_m, bearing_rad = (values.ravel()[candidates].astype(np.float64) for values in (VIEW.range_m, VIEW.bearing_rad))
    floor = np.stack([range_m * np.cos(bearing_rad), range_m * np.sin(bearing_rad)], axis=-1)
    near = ((floor >= hull.min(axis=0)) & (floor <= hull.max(axis=0))).all(axis=1)  # spares most of the work
    mask = np.zeros(VIEW.valid.shape, np.uint8)
    mask.flat[candidates[near]] = (_left_of_edges(floor[near], hull) >= 0.0).all(axis=1)
    return mask


def _left_of_edges(points: Array, polygon: Array) -> Array:
    """Return on which side of every edge of a polygon, (m, 2), the points (n, 2) lie: (n, m), positive to the left."""
    (edge_x, edge_y), (x, y) = (np.roll(polygon, -1, axis=0) - polygon).T, np.moveaxis(points[:, None] - polygon, -1, 0)
    return np.asarray(edge_x * y - edge_y * x)


def view_pixels(floor_m: ArrayLike) -> Array:
    """Return where floor points, (n, 2) [m], are in the view, (n, 2) [px]."""
    return VIEW.view_pixels(PROJECTION.pixels_from_floor(floor_m))


def watched(points: ArrayLike, label: int = 1, way_m: Array = WAY_M, along: bool = False) -> Tracks:
    """Return the tracks of points, (n, 3) [m], standing still, or moving along with the camera, seen from all over its way, (m, 2) [m]."""
    places = [appearances(points, eye) if not along else appearances(points, way_m[-1]) + eye - way_m[-1] for eye in way_m]
    pixels = view_pixels(places[-1])
    sigmas = np.full(len(pixels), SIGMA_M)
    tracks = begin(pixels, np.full(len(pixels), label, np.int32), places[0], sigmas, way_m[0])
    for place, eye in zip(places[1:], way_m[1:], strict=True):
        tracks = observe(tracks, pixels, place, sigmas, eye)
    return tracks
