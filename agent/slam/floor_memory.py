"""What is proven to lie in the floor: from two places it looks the same, seen as floor, while what stands there is shifted against it.

A point at height h, seen by a camera at height H that went b along, appears to have moved by b h / (H - h) on the floor: plane and parallax
(Kumar, Anandan and Hanna, "Direct recovery of shape from multiple views", ICPR 1994). No corners are needed, only some grain.
"""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from agent.vision.floor_patch import Field, FloorPatch
from agent.vision.floor_view import Picture
from agent.vision.outlines import Mask
from agent.vision.robot_outlines import covered
from protocol.geometry import Array, Pose2

SPACING, BASELINE = 0.1, 0.15  # of the camera's height: between views that are kept, and from which on parallax tells
VIEWS = 12
LIKENESS_CELLS = 7  # width of the window in which two views are compared
AGREEING, SLACK = 0.8, 0.1  # likeness of what lies flat, all but a tenth of it
UNSEEN, LEAST_SEEN = -2.0, 0.8  # likeness where no view tells, and of how much of an outline one has to
RIM_CELLS = 2  # around an outline: its border tells most
GRAIN_CELLS = 9  # width of the window whose mean does not count
CLEAR_CELLS = 4  # from the own body and from other robots, to which that window must not reach
LEAST_CELLS = 20
GAP_M = 0.045  # around another robot: its contact shadow, the window of the grain, and what its place is wrong by

_LOG = np.log(np.arange(256) + 4.0).astype(np.float32)


class _View(NamedTuple):
    """The floor as it was seen from one place."""

    odom_from_body: Pose2
    cells: Picture  # (size, size) grey
    clear: Mask  # (size, size) 1 where the floor was in view, 0 beside and behind robots


class _Region(NamedTuple):
    """One outline in the newest patch."""

    points_m: Array  # (rows, cols, 2) [body] of a window around it
    grain: Field  # (rows, cols) of that window
    power: Field  # (rows, cols) of the grain, summed nearby
    inside: NDArray[np.bool_]  # (rows, cols)


class FloorMemory:
    """Remembers how the floor looked from the robot's last places."""

    def __init__(self, patch: FloorPatch, body_range_m: float, body_radius_m: float, eye_m: Array) -> None:
        """Take where the own body ends to hide the floor, how large robots are, and where the camera is, (2,) [body]."""
        self._patch, self._body_radius_m, self._eye_m = patch, body_radius_m, eye_m
        range_m = np.hypot(*np.moveaxis(patch.points_m, -1, 0))
        margin_m = CLEAR_CELLS * patch.cell_m
        self._ring: Mask = ((range_m > body_range_m + margin_m) & (range_m < patch.reach_m - margin_m)).astype(np.uint8)
        self._views: deque[_View] = deque(maxlen=VIEWS)

    def remember(self, cells: Picture, robots_m: Array, odom_from_body: Pose2) -> None:
        """Keep the newest patch, (size, size) grey, if it was taken from a new place, with robots at (n, 2) [body]."""
        if self._views:
            way = self._views[-1].odom_from_body.between(odom_from_body)
            if np.hypot(way.x_m, way.y_m) < SPACING * self._patch.height_m:
                return
        self._views.append(_View(odom_from_body, cells, self._clear(robots_m)))

    def lies_flat(self, outline_m: Array, cells: Picture, odom_from_body: Pose2) -> bool | None:
        """Tell whether all within an outline, (n, 2) [body], lies in the floor, given the newest patch; None: no view can tell."""
        agreement = self._agreement(outline_m, cells, odom_from_body)
        return None if agreement is None else agreement > AGREEING

    def _agreement(self, outline_m: Array, cells: Picture, odom_from_body: Pose2) -> float | None:
        """Return how alike all but SLACK of an outline looks from the robot's earlier places, -1 to 1; None: no view can tell."""
        region = self._region(outline_m, cells)
        if region is None:
            return None
        best = np.full(region.grain.shape, UNSEEN, np.float32)
        for view in self._views:
            way = view.odom_from_body.between(odom_from_body)
            if np.hypot(way.x_m, way.y_m) >= BASELINE * self._patch.height_m:
                np.maximum(best, self._likeness(region, view, way), out=best)
        told = best[region.inside]
        is_seen = told > UNSEEN
        return float(np.quantile(told[is_seen], SLACK)) if is_seen.mean() > LEAST_SEEN else None

    def _clear(self, robots_m: Array) -> Mask:
        clear: Mask = self._ring.copy()
        radius_m = self._body_radius_m + GAP_M
        for centre_m in robots_m[np.hypot(*(robots_m - self._eye_m).T) > radius_m]:
            hidden = self._patch.cells(covered(centre_m, radius_m, self._eye_m, 2.0 * self._patch.reach_m))
            cv2.fillConvexPoly(clear, np.rint(hidden[:, ::-1]).astype(np.int32), 0)
        return clear

    def _region(self, outline_m: Array, cells: Picture) -> _Region | None:
        """Return an outline's part of the newest patch; None where the patch does not show all of it, or too little."""
        if np.hypot(*outline_m.T).max() > self._patch.reach_m - CLEAR_CELLS * self._patch.cell_m:
            return None
        corners = np.rint(self._patch.cells(outline_m)).astype(np.int32)
        margin = RIM_CELLS + GRAIN_CELLS // 2
        first, last = np.maximum(corners.min(axis=0) - margin, 0), corners.max(axis=0) + margin + 1
        window = (slice(first[0], last[0]), slice(first[1], last[1]))
        filled = cv2.fillPoly(np.zeros(cells[window].shape, np.uint8), [(corners - first)[:, ::-1]], 1)
        whole = (cv2.dilate(filled, np.ones((2 * RIM_CELLS + 1,) * 2, np.uint8)) > 0) & (self._ring[window] > 0)
        if whole.sum() < LEAST_CELLS:
            return None
        grain = _grain(cells[window])
        return _Region(self._patch.points_m[window], grain, _near_sum(grain * grain), whole)

    def _likeness(self, region: _Region, view: _View, view_from_body: Pose2) -> Field:
        """Return how alike a region's floor looks in an earlier view, (rows, cols), -1 to 1; UNSEEN where it was not in sight."""
        places = self._patch.cells(view_from_body.apply(region.points_m.reshape(-1, 2))).reshape(region.points_m.shape).astype(np.float32)
        rows, columns = places[..., 0], places[..., 1]
        clear = cv2.remap(view.clear, columns, rows, cv2.INTER_NEAREST, borderValue=0)
        then = _grain(np.asarray(cv2.remap(view.cells, columns, rows, cv2.INTER_LINEAR), np.uint8))
        both, power = _near_sum(region.grain * then), _near_sum(then * then)
        return np.where(clear > 0, both / np.sqrt(region.power * power + 1e-12), np.float32(UNSEEN)).astype(np.float32)


def _near_sum(field: Field) -> Field:
    return np.asarray(cv2.boxFilter(field, -1, (LIKENESS_CELLS, LIKENESS_CELLS), normalize=False), np.float32)


def _grain(cells: Picture) -> Field:
    """Return the fine texture of a patch, which no smooth shadow changes."""
    brightness = np.asarray(cv2.LUT(cells, _LOG), np.float32)
    return np.asarray(cv2.GaussianBlur(brightness, (0, 0), 1.0) - cv2.blur(brightness, (GRAIN_CELLS, GRAIN_CELLS)), np.float32)
