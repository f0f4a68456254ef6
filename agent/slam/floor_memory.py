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
    grain: Field  # (size, size)
    clear: Mask  # (size, size) 1 where the floor was in view, 0 beside and behind robots


class _Region(NamedTuple):
    """One outline in the newest patch."""

    first: NDArray[np.int32]  # (2,) row and column at which a window around it begins
    grain: Field  # (rows, cols) of that window
    power: Field  # (rows, cols) of the grain's square, summed nearby
    inside: Mask  # (rows, cols) 1 within the outline


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
        self._views.append(_View(odom_from_body, _grain(cells), self._clear(robots_m)))

    def lies_flat(self, outline_m: Array, cells: Picture, odom_from_body: Pose2) -> bool | None:
        """Tell whether all but SLACK of an outline, (n, 2) [body], lies in the floor, given the newest patch; None: no view can tell."""
        region = self._region(outline_m, cells)
        if region is None:
            return None
        best = np.full(region.grain.shape, UNSEEN, np.float32)
        for view in reversed(self._views):
            way = view.odom_from_body.between(odom_from_body)
            if np.hypot(way.x_m, way.y_m) >= BASELINE * self._patch.height_m:
                np.maximum(best, self._likeness(region, view, way), out=best)
                if _share(best > AGREEING, region.inside) >= 1.0 - SLACK:
                    return True
        seen = _share(best > UNSEEN, region.inside)
        return bool(_share(best > AGREEING, region.inside) >= (1.0 - SLACK) * seen) if seen > LEAST_SEEN else None

    def _clear(self, robots_m: Array) -> Mask:
        clear: Mask = self._ring.copy()
        radius_m = self._body_radius_m + GAP_M
        seen_m = robots_m[np.hypot(*(robots_m - self._eye_m).T) > radius_m]
        hidden = self._patch.cells(covered(seen_m, radius_m, self._eye_m, 2.0 * self._patch.reach_m))
        for polygon in np.rint(hidden[..., ::-1]).astype(np.int32):
            cv2.fillConvexPoly(clear, polygon, 0)
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
        return _Region(first, grain, _near_sum(grain * grain), whole.view(np.uint8))

    def _likeness(self, region: _Region, view: _View, view_from_body: Pose2) -> Field:
        """Return how alike a region's floor looks in an earlier view, (rows, cols), -1 to 1; UNSEEN where it was not in sight."""
        moved, size = self._cells_moved(view_from_body, region.first), region.grain.shape[::-1]
        then = np.asarray(cv2.warpAffine(view.grain, moved, size, flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP), np.float32)
        clear = cv2.warpAffine(view.clear, moved, size, flags=cv2.INTER_NEAREST | cv2.WARP_INVERSE_MAP)
        both, power = _near_sum(region.grain * then), _near_sum(then * then)
        return np.where(clear > 0, both / np.sqrt(region.power * power + 1e-12), np.float32(UNSEEN)).astype(np.float32)

    def _cells_moved(self, view_from_body: Pose2, first: NDArray[np.int32]) -> Array:
        """Return what takes column and row of a window that begins at row and column `first` to those of a view's patch, (2, 3)."""
        corner = first + np.array([[0, 0], [0, 1], [1, 0]])
        begin, next_column, next_row = self._patch.cells(view_from_body.apply(self._patch.points_m[corner[:, 0], corner[:, 1]]))[:, ::-1]
        return np.column_stack([next_column - begin, next_row - begin, begin])


def _share(field: NDArray[np.bool_], inside: Mask) -> float:
    """Return of how much of a region, (rows, cols) 1 inside, something is true."""
    return cv2.countNonZero(inside & field.view(np.uint8)) / cv2.countNonZero(inside)


def _near_sum(field: Field) -> Field:
    return np.asarray(cv2.boxFilter(field, -1, (LIKENESS_CELLS, LIKENESS_CELLS), normalize=False), np.float32)


def _grain(cells: Picture) -> Field:
    """Return the fine texture of a patch, which no smooth shadow changes."""
    brightness = np.asarray(cv2.LUT(cells, _LOG), np.float32)
    return np.asarray(cv2.GaussianBlur(brightness, (0, 0), 1.0) - cv2.blur(brightness, (GRAIN_CELLS, GRAIN_CELLS)), np.float32)
