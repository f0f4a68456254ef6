"""From the light on a sensor to its picture: vignetting, exposure and noise."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from sim.world.view import View

Picture = NDArray[np.uint8]

NOISE_LEVELS = 0.8  # one sigma: with the floors' own grain as rough as in the recordings
VIGNETTING = 0.14  # loss of light at 80 degrees off the axis ...
EDGE_RAD = 0.02  # over which the light fades at the edge of the lens
DARK_LEVEL, NOISE_TILE_PX = 15, 512


class Sensor:
    """One camera's sensor. Its noise is a function of its seed and of how many pictures it has taken."""

    def __init__(self, view: View, exposure: float, seed: tuple[int, ...]) -> None:
        angle = np.where(view.in_field, view.off_axis_rad, np.float32(view.lens.widest_rad))
        at_edge = np.clip((view.lens.widest_rad - angle) / EDGE_RAD, 0.0, 1.0)
        passed = (255.0 * at_edge * np.clip(1.0 - VIGNETTING * (angle / 1.4) ** 4, 0.0, 1.0)).astype(np.uint8)
        gain = view.picture_of(np.repeat(passed[..., None], 3, axis=-1))
        self._gain = gain
        self._exposure = exposure / 255.0
        self._floor = np.where(gain == 0, np.uint8(DARK_LEVEL), np.uint8(0)).astype(np.uint8)
        self._rng = np.random.default_rng([*seed, 2])
        tile = self._rng.normal(0.0, NOISE_LEVELS, (NOISE_TILE_PX, NOISE_TILE_PX, 3))
        repeats = (view.size_px[1] // NOISE_TILE_PX + 2, view.size_px[0] // NOISE_TILE_PX + 2, 1)
        self._noise = np.tile(np.clip(np.rint(tile), -100, 100).astype(np.int8), repeats)

    def take(self, light: Picture) -> Picture:
        """Return the picture of the light that falls on the sensor, (height, width, 3) BGR."""
        developed = cv2.multiply(light, self._gain, scale=self._exposure)
        row, column = self._rng.integers(0, NOISE_TILE_PX, 2).tolist()
        height, width = light.shape[:2]
        noise = np.ascontiguousarray(self._noise[row : row + height, column : column + width])
        return np.asarray(cv2.add(cv2.add(developed, self._floor), noise, dtype=cv2.CV_8U), np.uint8)
