"""The nearest thing in every direction, as a lidar would measure it, and where in it a robot's round base may be."""

from __future__ import annotations

import numpy as np

from agent.vision.floor_projection import FloorProjection
from agent.vision.floor_view import FloorView
from agent.vision.outlines import Borders
from agent.vision.robust import median
from protocol.geometry import Array

DIRECTIONS = 360  # a degree each: 1 cm at 0.6 m, finer than the outline
_SAMPLES = np.linspace(-0.85, 0.85, 11)  # across a base, in half widths of its angle; farther out its border turns away
_AXIS_SHARES = np.array([0.15, 0.3, 0.45, 0.6, 0.75, 0.9])  # of the height, where something must be seen
_AXIS_COVERED = 0.8
_LEAST_COVERED = 8  # of these samples, where the rest may be hidden


def range_profile(borders: Borders, view: FloorView, eye_m: Array) -> Array:
    """Return the range, (DIRECTIONS,) [m], from the point under the camera, (2,) [m; body], to the first thing; inf where there is none.

    Directions run counter-clockwise from -pi of the body's x axis.
    """
    floor = view.floor_of(np.concatenate([np.zeros((0, 2), np.int32), *borders.pixels])) - eye_m
    range_m = np.hypot(floor[:, 0], floor[:, 1])
    profile = np.full(DIRECTIONS, np.inf)
    np.minimum.at(profile, _direction(np.arctan2(floor[:, 1], floor[:, 0])), np.nan_to_num(range_m, nan=np.inf))
    return profile


def round_bases(profile: Array, radius_m: float, tolerance_m: float) -> Array:
    """Return where robots may stand, (n, 2) range and bearing of the base centre [m, rad], the best fitting first.

    The profile across a base must be that of a circle of `radius_m` to within `tolerance_m`, in the median, and a pixel's size farther out.
    """
    seen = np.flatnonzero(np.isfinite(profile))
    bearing = (seen + 0.5) * (2.0 * np.pi / DIRECTIONS) - np.pi
    distance = profile[seen] + radius_m
    half = np.arcsin(radius_m / distance)
    offsets = half[:, None] * _SAMPLES
    measured = profile[_direction(bearing[:, None] + offsets)]
    circle = distance[:, None] * np.cos(offsets) - np.sqrt(radius_m**2 - (distance[:, None] * np.sin(offsets)) ** 2)
    difference = np.abs(np.nan_to_num(measured, posinf=1e3) - circle)
    misfit = median(difference) / (1.0 + distance**2)
    covered = (difference < 4.0 * tolerance_m * (1.0 + distance[:, None] ** 2)).sum(axis=1) >= _LEAST_COVERED
    left = covered & (misfit <= tolerance_m)
    best: list[int] = []
    while left.any():
        candidate = int(np.argmin(np.where(left, misfit, np.inf)))
        best.append(candidate)
        left &= np.abs((bearing - bearing[candidate] + np.pi) % (2.0 * np.pi) - np.pi) > half[candidate]
    return np.stack([distance[best], bearing[best]], axis=-1)


def tall_bases(bases: Array, height_m: float, borders: Borders, view: FloorView, projection: FloorProjection) -> Array:
    """Return those of `bases`, (n, 2) range and bearing from the camera, above which something rises to `height_m`, as a robot does."""
    if not len(bases):
        return bases
    range_m, bearing = bases.T
    axis = projection.body_from_camera[:2, 3] + (range_m * np.stack([np.cos(bearing), np.sin(bearing)])).T
    heights = height_m * _AXIS_SHARES
    points = np.concatenate([np.repeat(axis, len(heights), axis=0), np.tile(heights, len(axis))[:, None]], axis=1)
    pixels = view.view_pixels(projection.pixels_from_points(points))
    inside = np.all((pixels >= 0.0) & (pixels < (view.valid.shape[1] - 1, view.valid.shape[0] - 1)), axis=1)
    u, v = np.rint(np.where(inside[:, None], pixels, 0.0)).astype(np.intp).T
    in_view = (inside & view.valid[v, u]).reshape(len(axis), -1)
    covered = in_view & (borders.numbers[v, u] > 0).reshape(len(axis), -1)
    return np.asarray(bases[covered.sum(axis=1) >= _AXIS_COVERED * in_view.sum(axis=1)])


def _direction(bearing_rad: Array) -> np.ndarray[tuple[int, ...], np.dtype[np.intp]]:
    return np.floor((bearing_rad + np.pi) * (DIRECTIONS / (2.0 * np.pi))).astype(np.intp) % DIRECTIONS
