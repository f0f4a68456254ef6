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
LEAST_BORDER_PX = 80  # around two things, each so wide at the robot's own rim
NOTHING_M = 1e3  # the range where a region is not seen
CUT_PX = 2  # wide enough that what remains is not connected across a corner


def cut_at_depth_steps(not_floor: Mask, view: FloorView, least_step_m: float) -> Mask:
    """Return the mask, (rows, cols) of the view, cut along the line of sight wherever a region's near border leaps by `least_step_m`."""
    contours, _ = cv2.findContours(not_floor, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    borders = [np.asarray(contour[:, 0], np.int32) for contour in contours if len(contour) > LEAST_BORDER_PX]
    rays = [ray for border in borders for ray in _cuts(border, view, least_step_m)]
    if not rays:
        return not_floor
    opened = not_floor.copy()
    for ray in rays:
        (first_u, first_v), (last_u, last_v) = np.rint(ray).astype(int).tolist()
        cv2.line(opened, (first_u, first_v), (last_u, last_v), 0, CUT_PX)
    return opened


def _cuts(border: Border, view: FloorView, least_step_m: float) -> list[Array]:
    """Return the cuts, each (2, 2) from and to [view px], that part a region with this border, (n, 2) u, v."""
    u, v = border.T
    range_m = view.range_m[v, u]
    opposite = float(view.bearing_rad[v, u][np.argmin(range_m)]) - np.pi  # directions are counted from where the region is not
    bins = ((view.bearing_rad[v, u] - opposite) % (2.0 * np.pi) * (BINS / (2.0 * np.pi))).astype(np.intp) % BINS
    near_m = np.full(BINS, NOTHING_M)
    np.minimum.at(near_m, bins, range_m)
    return [_cut(border[bins == step] - view.nadir_px) + view.nadir_px for step in _steps(near_m, least_step_m)]


def _cut(offsets: Array) -> Array:
    """Return the ray, (2, 2) from and to, along border pixels of one direction, (n, 2) [px from the point under the camera]."""
    radius = np.hypot(*offsets.T)
    along = (offsets / radius[:, None]).mean(axis=0)
    return np.outer([radius.min() - 2.0 * CUT_PX, radius.max() + 2.0 * CUT_PX], along)


def _steps(near_m: Array, least_step_m: float) -> list[int]:
    """Return the directions in which a thing behind begins to be seen beside one in front, given the least range in each, (BINS,)."""
    leap_m = np.diff(near_m)
    seen = (near_m[:-1] < NOTHING_M) & (near_m[1:] < NOTHING_M)
    away, back = np.flatnonzero(seen & (leap_m > least_step_m)), np.flatnonzero(seen & (leap_m < -least_step_m))
    after = [int(i) + 1 for i in away if _are_two(near_m[i::-1], near_m[i + 1 :], least_step_m)]
    before = [int(i) for i in back if _are_two(near_m[i + 1 :], near_m[i::-1], least_step_m)]
    return after + before


def _are_two(front_m: Array, behind_m: Array, least_step_m: float) -> bool:
    """Tell whether the ranges on both sides of a leap, counted from it, are of two things: wide enough, and one all behind the other."""
    front, behind = front_m[:LEAST_SPAN], behind_m[:LEAST_SPAN]
    wide = len(front) == len(behind) == LEAST_SPAN and behind.max() < NOTHING_M
    return bool(wide and behind.min() > front.max() + 0.5 * least_step_m)
