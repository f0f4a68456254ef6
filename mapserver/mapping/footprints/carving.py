"""What of some cells belongs to one convex thing, by how much speaks for each cell and how much against it.

A thing is convex, and no floor that was seen bare lies in it. So the convex hull of all cells that speak for a thing is cut by straight
lines, one after the other, each of which takes away more that speaks against it than for it.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from protocol.geometry import Array

DIRECTIONS = 36  # of cuts that are tried
MOST_CUTS = 6
LEAST_GAIN_CELLS, LEAST_GAIN_SHARE = 12.0, 0.02  # of a cut: more against the thing than for it, also as a share of its cells
MOST_SAMPLES = 4000  # of cells that are looked at: of a large thing every second one, or third, along each axis

_TURN = np.arange(DIRECTIONS) * (2.0 * np.pi / DIRECTIONS)
_NORMALS = np.stack([np.cos(_TURN), np.sin(_TURN)])  # (2, DIRECTIONS)


def carved(worth: NDArray[np.float32]) -> NDArray[np.int_]:
    """Return the corners, (n, 2) column and row, of the convex part of a raster that is worth most, as far as straight cuts find it.

    `worth`, (rows, cols), is positive where a cell speaks for the thing, as one does at least, and negative where it speaks against it.
    """
    hull = _hull(_outermost(worth > 0.0))
    inside = cv2.fillConvexPoly(np.zeros(worth.shape, np.uint8), hull.astype(np.int32), 1)
    step = int(np.ceil(np.sqrt(max(cv2.countNonZero(inside) / MOST_SAMPLES, 1.0))))
    rows, columns = np.nonzero(inside[::step, ::step])
    cells, weights = step * np.stack([columns, rows], axis=-1), worth[step * rows, step * columns].astype(np.float64)
    least = max(LEAST_GAIN_CELLS / step**2, LEAST_GAIN_SHARE * len(cells))
    kept = cells
    for _ in range(MOST_CUTS):
        left = _cut(kept, weights, step, least)
        if left is None or not (weights[left] > 0.0).any():
            break
        kept, weights = kept[left], weights[left]
    return hull if kept is cells else _hull(kept[weights > 0.0])


def _cut(cells: NDArray[np.int_], weights: Array, step: int, least: float) -> NDArray[np.bool_] | None:
    """Return which cells, (n, 2), the best cut leaves, (n,); None where no cut gains as much as `least`."""
    reach = np.floor(cells @ _NORMALS / step).astype(int)  # (n, DIRECTIONS)
    reach -= reach.min(axis=0)
    best, left = least, None
    for along in reach.T:
        beyond = np.cumsum(np.bincount(along, weights)[::-1])[::-1]  # the worth of all that is as far or farther
        at = int(np.argmin(beyond))
        if -beyond[at] > best:
            best, left = float(-beyond[at]), along < at
    return left


def _outermost(mask: NDArray[np.bool_]) -> NDArray[np.int_]:
    """Return column and row, (n, 2), of the first and the last cell of every row that has any: the hull of these is that of all."""
    rows = np.flatnonzero(mask.any(axis=1))
    filled = mask[rows]
    first, last = filled.argmax(axis=1), filled.shape[1] - 1 - filled[:, ::-1].argmax(axis=1)
    return np.column_stack([np.concatenate([first, last]), np.concatenate([rows, rows])])


def _hull(cells: NDArray[np.int_]) -> NDArray[np.int_]:
    return np.asarray(cv2.convexHull(cells.astype(np.int32)).reshape(-1, 2), np.int_)
