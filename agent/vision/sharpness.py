"""Whether the lens is in focus: how sharp the hardest edges in the picture's middle are, whatever floor the robot stands on.

The own rim is always there, moves with the camera, and so is sharp in every picture that is: on a floor without texture, and in a fast
turn. Where the floor has harder edges, those tell.
"""

from __future__ import annotations

from collections import deque
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from agent.vision.robust import median

Picture = NDArray[np.uint8]

BLOCK_PX, COARSE_PX = 8, 9
STRONG_SHARE = 0.15  # of the blocks: those with the most contrast have the hardest edges
LEAST_CONTRAST = 7.0  # grey levels, root mean square in a block: less tells nothing
LEAST_BLOCKS = 12
LOOKS = 10  # that have to agree
LOST_SHARE = 0.6  # of what the sharpness was: an edge that had a width of a pixel has two
BLURRED = 0.5  # an edge is this sharp where it is smeared by one and a half pixels; a lens in focus gives 0.8 and more

LOST_FOCUS = "camera: out of focus: turn the lens until the own rim is sharp, lock it, and calibrate it again"


def sharpness(middle: Picture) -> float | None:
    """Return how sharp the hardest edges of a part of a picture, (rows, cols) grey, are; None where it has none.

    It is the ratio of energies, as amplitudes, of the Laplacian and of the contrast in the strongest blocks: 1.7 for a step, about
    1.2 / sigma where a step is smeared by sigma >= 1 px. What the Laplacian shows in the blocks with the least contrast is noise.
    """
    rows, cols = (length // BLOCK_PX for length in middle.shape)
    if rows * cols < LEAST_BLOCKS:
        return None
    grey = middle[: rows * BLOCK_PX, : cols * BLOCK_PX].astype(np.float32)
    fine = _block_means(cv2.Laplacian(grey, cv2.CV_32F) ** 2, rows, cols)
    coarse = _block_means((grey - cv2.blur(grey, (COARSE_PX, COARSE_PX))) ** 2, rows, cols)
    order = np.argsort(coarse)
    strong = order[-max(LEAST_BLOCKS, round(STRONG_SHARE * len(order))) :]
    strong = strong[coarse[strong] > LEAST_CONTRAST**2]
    if len(strong) < LEAST_BLOCKS:
        return None
    weak = order[: len(order) // 2]
    noise = float(fine[weak].mean()), float(coarse[weak].mean())
    edges = fine[strong].mean() - noise[0], coarse[strong].mean() - noise[1]
    return float(np.sqrt(max(edges[0], 0.0) / max(edges[1], 1.0)))


class Focus:
    """Compares the sharpness of one camera's pictures with what it was at first, and with what a lens in focus gives."""

    def __init__(self) -> None:
        self._reference: float | None = None
        self._last: deque[float] = deque(maxlen=LOOKS)

    def look(self, middle: Picture) -> None:
        """Take the picture's middle, (rows, cols) grey."""
        found = sharpness(middle)
        if found is None and self._reference is None:
            return  # there never was an edge to be sharp
        self._last.append(found or 0.0)
        if self._reference is None and len(self._last) == LOOKS:
            self._reference = self._median()

    @property
    def complaint(self) -> str:
        """One line with the remedy where focus is lost; empty where it is not."""
        if self._reference is None:
            return ""
        return LOST_FOCUS if self._median() < max(BLURRED, LOST_SHARE * self._reference) else ""

    def _median(self) -> float:
        return float(median(np.array(self._last)))


def _block_means(field: NDArray[Any], rows: int, cols: int) -> NDArray[np.float32]:
    """Return the means of blocks, (rows * cols,)."""
    return np.asarray(cv2.resize(field, (cols, rows), interpolation=cv2.INTER_AREA), np.float32).ravel()
