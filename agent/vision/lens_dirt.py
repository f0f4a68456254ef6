"""Dirt on the lens: places in the picture where the floor does not go by while the robot drives.

Dirt hides the floor, and a smear blurs it: in both, fine structure hardly ever changes from one picture to the next, while it does so
nearly always elsewhere at the same distance. The own body, where nothing changes, shows how much of a change is noise. On a floor so
plain that many cells seldom change, nothing can be told, whatever passes by now and then.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from protocol.geometry import Array

Picture = NDArray[np.uint8]
Mask = NDArray[np.bool_]

CELL_PX = 4  # of the small picture
FINE_PX = 5  # of the small picture: what is wider than this is not fine
LOOKS = 60  # until a verdict, each from another place
RINGS = 6  # of cells that see floor at about the same distance
NOISE_TIMES = 4.0  # a change is seen where it is so many times what it is on the own body, which is darker, and so has less noise
LOW_PERCENTILE = 15.0  # of the cells in a ring: as often as these change all clean ones do; more than so many are never dirty
LEAST_OFTEN = 0.6  # of the looks: where these change more seldom, the floor is too plain
DIRTY_OFTEN = 0.1  # of the looks: a cell that changes more seldom is dirty
LEAST_CELLS = 3
LEAST_LOOKS_SHARE = 0.5  # in which a cell was not hidden by a robot
AGREEING = 2  # verdicts in a row that name the same cell: a robot beside this one may hide it for one


class LensDirt:
    """Counts how often each cell of one camera's picture changes."""

    def __init__(self, radius: Array, bearing_rad: Array, floor: Mask, body: Mask) -> None:
        """Take what each cell, (rows, cols), shows.

        `radius` is its distance from the picture's middle in any unit, `bearing_rad` [body] where on the floor it is; `floor` and `body`
        are the cells that show floor near enough to go by, and the own body.
        """
        self._bearing_rad, self._floor, self._body = bearing_rad, floor, body
        edges = np.quantile(radius[floor], np.linspace(0.0, 1.0, RINGS + 1)[1:-1])
        self._ring = np.where(floor, np.digitize(radius, edges), -1)
        self._before: NDArray[np.float32] | None = None
        self._suspected = np.zeros((AGREEING, *floor.shape), bool)  # by the last verdicts
        self._begin()

    def look(self, small: Picture, robots: Array) -> None:
        """Take a picture from a new place, (CELL_PX rows, CELL_PX cols) grey; `robots` are bearing and half width, (n, 2) [rad]."""
        grey = small.astype(np.float32)
        fine = grey - cv2.blur(grey, (FINE_PX, FINE_PX))
        before, self._before = self._before, np.asarray(fine, np.float32)
        if before is None:
            return
        rows, cols = self._floor.shape
        change = cv2.resize((fine - before) ** 2, (cols, rows), interpolation=cv2.INTER_AREA)
        counted = ~self._hidden(robots)
        seen = change > NOISE_TIMES * np.median(change[self._body])
        self._changes += counted & seen
        self._count += counted
        self._looks += 1
        if self._looks == LOOKS:
            self._suspected = np.concatenate([self._suspected[1:], self._verdict()[None]])
            self._begin()

    @property
    def dirty(self) -> Mask:
        """The cells, (rows, cols), that are dirty; none where that is not certain."""
        cells = np.asarray(self._suspected.all(axis=0))
        return cells if cells.sum() >= LEAST_CELLS else np.zeros_like(cells)

    def _begin(self) -> None:
        self._changes, self._count = (np.zeros(self._floor.shape, int) for _ in range(2))
        self._looks = 0

    def _hidden(self, robots: Array) -> Mask:
        """Return the cells, (rows, cols), in the direction of robots, which may drive along with this one."""
        hidden = np.zeros(self._floor.shape, bool)
        for bearing_rad, half_rad in robots:
            hidden |= np.abs(np.angle(np.exp(1j * (self._bearing_rad - bearing_rad)))) < half_rad
        return hidden

    def _verdict(self) -> Mask:
        """Return the cells, (rows, cols), that change too seldom."""
        often = self._changes / np.maximum(self._count, 1)
        dirty = np.zeros(self._floor.shape, bool)
        for number in range(RINGS):
            ring = (self._ring == number) & (self._count > LEAST_LOOKS_SHARE * LOOKS)
            if ring.any() and np.percentile(often[ring], LOW_PERCENTILE) > LEAST_OFTEN:
                dirty |= ring & (often < DIRTY_OFTEN)
        return dirty
