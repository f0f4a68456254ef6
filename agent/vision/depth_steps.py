"""Where one thing ends in front of another: steps in how far away a region begins, from one direction to the next.

The base line of an upright convex thing, seen from above, neither comes nearer nor goes farther by leaps: its sides stand along the line
of sight, so a region's near border is continuous from end to end. Where it leaps, one thing ends, and another that stands behind goes on.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from agent.vision.floor_view import FloorView
from protocol.geometry import Array

Mask = NDArray[np.uint8]
Border = NDArray[np.int32]

BINS = 720  # directions, half a degree each: a pixel or more of the view wherever a thing can stand
LEAST_SPAN = 8  # directions that the nearer and the farther thing must each take up: less is a ragged border
_SPAN = np.ones((1, LEAST_SPAN), np.uint8)
LEAST_BORDER_PX = 80  # around two things, each so wide at the robot's own rim
NOTHING_M = 1e3  # the range where a region is not seen
CUT_PX = 2  # wide enough that what remains is not connected across a corner


def cut_at_depth_steps(not_floor: Mask, view: FloorView, least_step_m: float) -> Mask:
    """Return the mask, (rows, cols) of the view, cut along the line of sight wherever a region's near border leaps by `least_step_m`."""
    contours, _ = cv2.findContours(not_floor, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    borders = [np.asarray(contour[:, 0], np.int32) for contour in contours if len(contour) > LEAST_BORDER_PX]
    rays = _cuts(borders, view, least_step_m) if borders else []
    if not rays:
        return not_floor
    opened = not_floor.copy()
    for ray in rays:
        (first_u, first_v), (last_u, last_v) = np.rint(ray).astype(int).tolist()
        cv2.line(opened, (first_u, first_v), (last_u, last_v), 0, CUT_PX)
    return opened


def _cuts(borders: list[Border], view: FloorView, least_step_m: float) -> list[Array]:
    """Return the cuts, each (2, 2) from and to [view px], that part regions with these borders, (n, 2) u, v each."""
    counts = np.array([len(border) for border in borders])
    pixels, border = np.concatenate(borders), np.repeat(np.arange(len(borders)), counts)
    u, v = pixels.T
    range_m, bearing_rad = view.range_m[v, u], view.bearing_rad[v, u]
    is_nearest = range_m == np.minimum.reduceat(range_m, np.cumsum(counts) - counts)[border]
    opposite = np.empty(len(borders), np.float32)  # directions are counted from where the region is not
    opposite[border[is_nearest]] = bearing_rad[is_nearest] - np.float32(np.pi)
    bins = ((bearing_rad - opposite[border]) % (2.0 * np.pi) * (BINS / (2.0 * np.pi))).astype(np.intp) % BINS
    near_m = np.full((len(borders), BINS), NOTHING_M)
    np.minimum.at(near_m, (border, bins), range_m)
    steps = _steps(near_m, least_step_m)
    return [_cut(pixels[(border == row) & (bins == step)] - view.nadir_px) + view.nadir_px for row, step in steps]


def _cut(offsets: Array) -> Array:
    """Return the ray, (2, 2) from and to, along border pixels of one direction, (n, 2) [px from the point under the camera]."""
    radius = np.hypot(*offsets.T)
    along = (offsets / radius[:, None]).mean(axis=0)
    return np.outer([radius.min() - 2.0 * CUT_PX, radius.max() + 2.0 * CUT_PX], along)


def _steps(near_m: Array, least_step_m: float) -> list[list[int]]:
    """Return border and direction where a thing behind begins to be seen beside one in front, given the least ranges, (borders, BINS).

    On both sides of such a leap there are two things: each wide enough, and the one all behind the other.
    """
    nearest, farthest = (extreme(near_m, _SPAN, anchor=(0, 0))[:, : 1 - LEAST_SPAN] for extreme in (cv2.erode, cv2.dilate))
    first, second = np.s_[:, :-LEAST_SPAN], np.s_[:, LEAST_SPAN:]  # the spans that end at a leap, and those that begin there
    leap_m = np.diff(near_m)[:, LEAST_SPAN - 1 : 1 - LEAST_SPAN]
    apart_m = 0.5 * least_step_m
    away = (leap_m > least_step_m) & (farthest[second] < NOTHING_M) & (nearest[second] > farthest[first] + apart_m)
    back = (leap_m < -least_step_m) & (farthest[first] < NOTHING_M) & (nearest[first] > farthest[second] + apart_m)
    places = [np.argwhere(away) + np.array([0, LEAST_SPAN]), np.argwhere(back) + np.array([0, LEAST_SPAN - 1])]
    steps: list[list[int]] = np.concatenate(places).tolist()
    return steps
