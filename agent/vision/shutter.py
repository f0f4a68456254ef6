"""A shutter that rolls: rows of one picture are taken at different moments, while the robot moves on."""

from __future__ import annotations

import numpy as np

from agent.vision.floor_patch import FloorPatch
from agent.vision.floor_projection import FloorProjection
from protocol.geometry import Array


class RollingShutter:
    """Tells where what a row shows would have been seen at the picture's stamp, which is that of its middle row."""

    def __init__(self, patch: FloorPatch, projection: FloorProjection, height_px: int, readout_s: float) -> None:
        """Take the time from the first row to the last; 0 for a shutter that opens everywhere at once."""
        self._patch = patch
        rows_px = np.nan_to_num(projection.pixels_from_floor(patch.points_m.reshape(-1, 2))[:, 1], nan=0.5 * (height_px - 1))
        self._late_s: Array = ((rows_px - 0.5 * (height_px - 1)) / height_px * readout_s).reshape(patch.points_m.shape[:2])
        self._rolls = readout_s > 0.0

    def displacement_m(self, points_m: Array, speed_m_s: float, turn_rad_s: float) -> Array:
        """Return how far floor points, (n, 2) [m; body] as they are seen, are from where they are at the stamp, (n, 2)."""
        if not self._rolls:
            return np.zeros_like(points_m)
        last = self._late_s.shape[0] - 1
        cells = np.clip(np.rint(self._patch.cells(points_m)).astype(int), 0, last)
        late_s = self._late_s[cells[:, 0], cells[:, 1]]
        velocity_m_s = np.column_stack([speed_m_s - turn_rad_s * points_m[:, 1], turn_rad_s * points_m[:, 0]])
        return np.asarray(velocity_m_s * late_s[:, None], np.float64)
