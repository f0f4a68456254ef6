"""What a person would otherwise do: follow the floor in a whole bird's-eye picture, with OpenCV's own tools at each step.

Every pixel of that picture is corrected for the lens, contrast is enhanced, Harris corners are found all over it and followed by pyramidal
Lucas-Kanade flow, and a rigid motion is fitted by RANSAC. Nothing is told apart yet: no floor, no object, no robot.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

import cv2
import numpy as np
from numpy.typing import NDArray

from agent.geometry import calibrated_projection
from agent.rig import Body, Calibration
from agent.vision.floor_projection import FloorProjection
from agent.vision.remap_table import RemapTable
from protocol.geometry import Array, Pose2

Picture = NDArray[np.uint8]
Points = NDArray[np.float32]

REACH_M = 0.5
CELLS_PER_WIDTH = 1000 / 1280  # a millimetre of floor a cell for a picture of 1280 columns
CONTRAST_LIMIT, CONTRAST_TILES = 2.0, (8, 8)
MOST_CORNERS, CORNER_DISTANCE_PX = 500, 7
CORNER_QUALITY = 1e-4  # of the strongest corner's response: that one stands on an object, the floor's own are far weaker
HARRIS_K, HARRIS_WINDOW_PX = 0.04, 3
FLOW_WINDOW_PX, FLOW_LEVELS = (21, 21), 3
OUTLIER_PX = 2.0
FEWEST_MATCHES = 3


@dataclass(frozen=True)
class _BirdsEye:
    """The last picture and its corners."""

    picture: Picture
    corners: Points  # (n, 2) u, v


class ClassicalMethod:
    """One robot's own motion, from frame to frame."""

    def __init__(self, body: Body, calibration: Calibration) -> None:
        projection = calibrated_projection(calibration)
        self._cells = round(CELLS_PER_WIDTH * calibration.width_px)
        self._cell_m = 2.0 * REACH_M / self._cells
        floor = self._floor_points()
        self._table = RemapTable(projection.pixels_from_floor(floor).reshape(self._cells, self._cells, 2))
        # The own body stands still in every picture: with its corners, "no motion" would win the vote.
        hidden = np.hypot(*floor.T) < _hidden_range_m(body, projection)
        self._mask = np.where(hidden, 0, 255).astype(np.uint8).reshape(self._cells, self._cells)
        self._contrast = cv2.createCLAHE(CONTRAST_LIMIT, CONTRAST_TILES)
        self._last: _BirdsEye | None = None

    def step(self, picture: Picture) -> Pose2 | None:
        """Return previous_from_body by a picture, (rows, cols, 3) BGR; None for the first one, and where no motion was found."""
        seen = self._table.sample(picture)
        enhanced = np.asarray(self._contrast.apply(cv2.cvtColor(seen, cv2.COLOR_BGR2GRAY)), np.uint8)
        motion = None if self._last is None else self._motion(self._last, enhanced)
        self._last = _BirdsEye(enhanced, self._corners(enhanced))
        return motion

    def _corners(self, picture: Picture) -> Points:
        found = cv2.goodFeaturesToTrack(
            picture,
            MOST_CORNERS,
            CORNER_QUALITY,
            CORNER_DISTANCE_PX,
            mask=self._mask,
            blockSize=HARRIS_WINDOW_PX,
            useHarrisDetector=True,
            k=HARRIS_K,
        )
        corners = cast("Points | None", found)
        return np.zeros((0, 2), np.float32) if corners is None else corners.reshape(-1, 2)

    def _motion(self, last: _BirdsEye, picture: Picture) -> Pose2 | None:
        if len(last.corners) < FEWEST_MATCHES:
            return None
        no_guess = np.zeros_like(last.corners)
        ends, found, _ = cv2.calcOpticalFlowPyrLK(
            last.picture, picture, last.corners, no_guess, winSize=FLOW_WINDOW_PX, maxLevel=FLOW_LEVELS
        )
        kept = found.ravel() != 0
        if kept.sum() < FEWEST_MATCHES:
            return None
        now, before = self._floor_from_cells(ends[kept]), self._floor_from_cells(last.corners[kept])
        found_motion, _ = cv2.estimateAffinePartial2D(now, before, method=cv2.RANSAC, ransacReprojThreshold=OUTLIER_PX * self._cell_m)
        fitted = cast("Array | None", found_motion)
        if fitted is None:
            return None
        return Pose2(float(fitted[0, 2]), float(fitted[1, 2]), float(np.arctan2(fitted[1, 0], fitted[0, 0])))

    def _floor_points(self) -> Array:
        """Return the floor point, (n, 2) [m; body], of every cell, row by row: forward is up, left is left."""
        rows, columns = np.mgrid[: self._cells, : self._cells]
        return self._floor_from_cells(np.stack([columns.ravel(), rows.ravel()], axis=-1))

    def _floor_from_cells(self, cells: NDArray[np.floating] | NDArray[np.integer]) -> Array:
        """Map cells, (n, 2) u, v, to floor points (n, 2) [m; body]."""
        return np.asarray((0.5 * (self._cells - 1) - cells[:, ::-1].astype(np.float64)) * self._cell_m)


def _hidden_range_m(body: Body, projection: FloorProjection) -> float:
    """Return how far [m] the robot's own rim hides the floor under it."""
    height_m = projection.camera_height_m
    return body.body_radius_m * height_m / (height_m - body.body_height_m)
