"""Other robots in the mask of what is not floor: whether one can stand at a place, and the mask without those that are known.

A robot before a box is one region with it, and the hull of both would take in the floor between them. So robots are cut out, and what they
touch in the picture keeps an outline of its own.
"""

from __future__ import annotations

import cv2
import numpy as np

from agent.rig import Body
from agent.vision.floor_projection import FloorProjection
from agent.vision.floor_view import FloorView
from agent.vision.outlines import SHIFT_BITS, Mask
from protocol.geometry import Array

GAP_M = 0.025  # around a robot: its contact shadow, and what its place is wrong by
_ARC_TURNS, _SIDES = np.linspace(-1.0, 1.0, 9), np.array([-1.0, 1.0])
NEAR_FACE, ASIDE = 0.85, np.array([-0.4, 0.0, 0.4])  # of a body's radius: where its side shows ...
UPWARDS = np.linspace(0.05, 0.9, 6)  # ... and of its height


def shown_share(not_floor: Mask, centre_m: Array, body: Body, view: FloorView, projection: FloorProjection) -> float:
    """Return how much of the near side of a robot, if it stood at (2,) [body], is no floor in a mask, (rows, cols): 0 to 1."""
    towards = projection.body_from_camera[:2, 3] - centre_m
    towards = towards / np.hypot(*towards)
    aside = np.array([-towards[1], towards[0]])
    faces = centre_m + body.body_radius_m * (NEAR_FACE * towards + ASIDE[:, None] * aside)
    heights_m = body.body_height_m * UPWARDS
    points = np.column_stack([np.tile(faces, (len(heights_m), 1)), np.repeat(heights_m, len(faces))])
    u, v = np.rint(np.nan_to_num(view.view_pixels(projection.pixels_from_points(points)), nan=-1.0)).astype(np.intp).T
    rows, cols = not_floor.shape
    inside = (u >= 0) & (u < cols) & (v >= 0) & (v < rows)
    return float(not_floor[v[inside], u[inside]].mean()) if inside.any() else 0.0


def parted_from_robots(not_floor: Mask, centres_m: Array, radius_m: float, view: FloorView, projection: FloorProjection) -> Mask:
    """Return the mask, (rows, cols) of the view, with a gap around every robot that stands at one of `centres_m`, (n, 2) [body]."""
    eye_m = projection.body_from_camera[:2, 3]
    distances_m = np.hypot(*(centres_m - eye_m).T)
    seen_m = centres_m[(distances_m > radius_m + GAP_M) & (distances_m < view.reach_m)]
    if not len(seen_m):
        return not_floor
    bodies, gaps = np.zeros_like(not_floor), np.zeros_like(not_floor)
    for mask, cover_m in ((bodies, radius_m), (gaps, radius_m + GAP_M)):
        corners_m = covered(seen_m, cover_m, eye_m, view.reach_m)
        corners_px = view.view_pixels(projection.pixels_from_floor(corners_m.reshape(-1, 2))).reshape(corners_m.shape)
        for polygon in np.rint(corners_px * (1 << SHIFT_BITS)).astype(np.int32):
            cv2.fillConvexPoly(mask, polygon, 1, shift=SHIFT_BITS)
    return not_floor * (gaps <= bodies)


def covered(centres_m: Array, radius_m: float, eye_m: Array, reach_m: float) -> Array:
    """Return the floor, polygons (n, corners, 2) [body], that tall cylinders at (n, 2) cover from an eye (2,).

    Each reaches from the near arc of its base outward.
    """
    away_m = centres_m - eye_m
    direction_rad = np.arctan2(away_m[:, 1], away_m[:, 0])[:, None]
    half_rad = np.arcsin(radius_m / np.hypot(away_m[:, 0], away_m[:, 1]))[:, None]
    near = centres_m[:, None] - radius_m * _unit(direction_rad - _ARC_TURNS * (0.5 * np.pi - half_rad))
    far = eye_m + reach_m * _unit(direction_rad - _SIDES * half_rad)
    return np.concatenate([near, far], axis=1)


def _unit(angles_rad: Array) -> Array:
    return np.stack([np.cos(angles_rad), np.sin(angles_rad)], axis=-1)
