"""Where in the picture other robots may be, whatever the floor looks like: silhouettes of robots all around are held against it.

A robot in a patch of sunlight, or before a box, is one region with it, whose border tells of no round base. Its silhouette stands out all
the same. All places up to a reach are tried, each sector in its turn, at a pixel a point; what is likely is for a fit to confirm.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from agent.vision.floor_projection import FloorProjection
from agent.vision.floor_view import Picture
from agent.vision.remap_table import RemapTable
from agent.vision.robot_fit import BASE_POINTS, SIDE_POINTS, silhouettes
from protocol.geometry import Array

SECTORS = 4
REACH_IN_HEIGHTS = 2.0  # farther out a robot is a few pixels wide
NEAREST_IN_RADII = 2.6  # nearer, its rim leaves the picture
STEP_RAD = 0.018  # between places, as the camera sees them; a search starts from within half of it
ACROSS_M = 5e-3  # from a point of the silhouette to where in and out are compared
CLIPPED = 24  # grey levels; beyond this a difference counts no more
LIKELY = 0.9  # of 1.5 at most; patterns, boxes and cylinders of other sizes come to about as much
MOST = 4  # places that are told of a sector: what was tried in vain there must not keep the rest from their turn
_COUNTS = np.array([BASE_POINTS, SIDE_POINTS, SIDE_POINTS]) // 2  # of every other point of base, left and right side
# What each point counts in the mean contrast of its part, (points, 3).
_SHARES = (np.repeat(np.eye(3), _COUNTS, axis=0) / (CLIPPED * _COUNTS)).astype(np.float32)


class RobotScan:
    """Holds silhouettes of one size against pictures of one camera; the camera may be drawn a little wrong."""

    def __init__(self, projection: FloorProjection, radius_m: float, height_m: float) -> None:
        self._radius_m = radius_m
        eye_m = projection.body_from_camera[:2, 3]
        polar = _places(projection.camera_height_m, radius_m)
        self._polar = [polar[_sector(polar[:, 1]) == number] for number in range(SECTORS)]
        self._tables = [_across(projection, eye_m, each, radius_m, height_m) for each in self._polar]

    def bases(self, grey: Picture, turn: int) -> Array:
        """Return where in one sector robots are likely to stand, (n, 2) range and bearing from the camera [m, rad], the likeliest first.

        Every `turn` is another sector's.
        """
        number = turn % SECTORS
        outer, inner = np.split(self._tables[number].pick(grey), 2)
        contrast = np.minimum(cv2.absdiff(outer, inner), CLIPPED).astype(np.float32)
        base, left, right = (contrast @ _SHARES).T
        scores = np.minimum(base, np.maximum(left, right)) + 0.5 * np.minimum(left, right)
        return _best(scores, self._polar[number], self._radius_m)


def _places(height_m: float, radius_m: float) -> Array:
    """Return all places to try, (n, 2) range and bearing [m, rad], as far apart as the camera sees the same angle between them."""
    depressions = np.arange(np.arctan(NEAREST_IN_RADII * radius_m / height_m), np.arctan(REACH_IN_HEIGHTS), STEP_RAD)
    rings = []
    for depression in depressions:
        count = int(np.ceil(2.0 * np.pi * depression / STEP_RAD))
        bearings = np.arange(count) * (2.0 * np.pi / count) - np.pi
        rings.append(np.column_stack([np.full(count, height_m * np.tan(depression)), bearings]))
    return np.concatenate(rings)


def _sector(bearing_rad: Array) -> NDArray[np.intp]:
    return np.floor((bearing_rad + np.pi) * (SECTORS / (2.0 * np.pi))).astype(np.intp) % SECTORS


def _across(projection: FloorProjection, eye_m: Array, polar: Array, radius_m: float, height_m: float) -> RemapTable:
    """Return the pixels on both sides of every other point of base and upright sides, (2 n, points), outside those of all places first."""
    range_m, bearing_rad = polar.T
    centres = eye_m + range_m[:, None] * np.stack([np.cos(bearing_rad), np.sin(bearing_rad)], axis=-1)
    shapes = silhouettes(centres, eye_m, radius_m, height_m)
    every = slice(0, BASE_POINTS + 2 * SIDE_POINTS, 2)
    points, normals = shapes.points[:, every], shapes.normals[:, every]
    ends = np.concatenate([points + ACROSS_M * normals, points - ACROSS_M * normals])
    pixels = projection.pixels_from_points(ends.reshape(-1, 3)).reshape(*ends.shape[:2], 2)
    return RemapTable(pixels + 0.5)  # whose whole parts are the nearest pixels


def _best(scores: Array, polar: Array, radius_m: float) -> Array:
    """Return the likeliest places, (n, 2) range and bearing, none of which stands inside another."""
    likely = scores > LIKELY
    left = polar[likely][np.argsort(-scores[likely], kind="stable")]
    best: list[Array] = []
    while len(left) and len(best) < MOST:
        best.append(left[0])
        range_m, towards = left[:, 0], left[:, 1] - left[0, 1]
        apart_m = np.hypot(range_m * np.cos(towards) - left[0, 0], range_m * np.sin(towards))
        left = left[apart_m > 2.0 * radius_m]
    return np.array(best).reshape(-1, 2)
