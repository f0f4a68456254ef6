"""Other robots in the mask of what is not floor, and the mask without those that are known.

A robot before a box is one region with it, and the hull of both would take in the floor between them. So robots are cut out, and what they
touch in the picture keeps an outline of its own.
"""

from __future__ import annotations

import cv2
import numpy as np

from agent.vision.floor_projection import FloorProjection
from agent.vision.floor_view import FloorView
from agent.vision.outlines import SHIFT_BITS, Mask
from protocol.geometry import Array

GAP_M = 0.025  # around a robot: its contact shadow, and what its place is wrong by
_ARC_TURNS, _SIDES = np.linspace(-1.0, 1.0, 9), np.array([-1.0, 1.0])


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
