"""The floor around the robot as a small picture seen from straight above, prepared for alignment.

Only the ring of floor that the lens resolves well is sampled, about a twentieth of the picture's pixels; it feeds the robot's own motion.
Rows run along the body's x axis, columns along its y axis, so that a cell's indices grow with the coordinates.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from agent.vision.floor_projection import FloorProjection
from agent.vision.floor_view import FloorView, Picture
from agent.vision.remap_table import RemapTable
from protocol.geometry import Array

Field = NDArray[np.float32]

CELL_IN_HEIGHTS = 0.01  # 5 mm for a camera half a metre high: about a pixel of a 1280 x 960 picture at 45 degrees off the axis
REACH_IN_HEIGHTS = 1.5
_FINE_CELLS = 0.8  # sigma of the smoothing that takes sensor noise away
_COARSE_CELLS = 21  # width of the window whose mean counts as illumination
_CONTRAST_CELLS = 25  # width of the window over which contrast is made even
_CONTRAST_FLOOR = 1.0  # grey levels: contrast below this is noise and is not raised


class FloorPatch:
    """Samples pictures of one camera onto square cells of floor."""

    def __init__(self, projection: FloorProjection, view: FloorView) -> None:
        height_m = projection.camera_height_m
        self.height_m = height_m  # of the camera
        self.cell_m = CELL_IN_HEIGHTS * height_m
        self.reach_m = REACH_IN_HEIGHTS * height_m
        half = round(self.reach_m / self.cell_m)
        axis = np.arange(-half, half + 1) * self.cell_m
        x, y = np.meshgrid(axis, axis, indexing="ij")
        self.half_cells = half
        self.points_m = np.stack([x, y], axis=-1)  # (size, size, 2) [body]
        range_m = np.hypot(x, y)
        pixels = projection.pixels_from_floor(self.points_m.reshape(-1, 2)).reshape(*x.shape, 2)
        self._table = RemapTable(pixels)
        self._view_table = RemapTable(view.view_pixels(pixels))
        self._ring = (range_m > view.body_range_m) & (range_m < self.reach_m - 2.0 * self.cell_m)

    def sample(self, grey: Picture) -> Picture:
        """Return the floor from above, (size, size), from a grey camera picture."""
        return self._table.sample(grey)

    def texture(self, floor: Picture) -> Field:
        """Return the fine texture, (size, size), of the floor from above: band-passed, with even contrast of about one."""
        cells = floor.astype(np.float32)
        fine = cv2.GaussianBlur(cells, (0, 0), _FINE_CELLS)
        band = cv2.subtract(fine, cv2.blur(cells, (_COARSE_CELLS, _COARSE_CELLS)))
        power = cv2.blur(cv2.multiply(band, band), (_CONTRAST_CELLS, _CONTRAST_CELLS))
        return np.asarray(cv2.divide(band, cv2.sqrt(np.maximum(power, 0.0)) + _CONTRAST_FLOOR), dtype=np.float32)

    def bare(self, not_floor: NDArray[np.uint8], margin_m: float) -> NDArray[np.bool_]:
        """Return which cells, (size, size), show bare floor at least `margin_m` away from anything in the mask of the view."""
        seen = self._view_table.pick(not_floor)
        width = 2 * round(margin_m / self.cell_m) + 1
        return np.asarray((cv2.dilate(seen, np.ones((width, width), np.uint8)) == 0) & self._ring)

    def cells(self, points_m: Array) -> Array:
        """Map floor points, shape (..., 2) [m; body], to row and column of a sampled patch, fractional."""
        return points_m / self.cell_m + self.half_cells
