"""Which cells with the base of something belong together: the pieces of one thing, as long as no bare floor parts them.

A wall round a room is no thing, but its base lines hang together: a cluster that is large and mostly encloses bare floor is cut in halves,
and again, until its parts are straight.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from mapserver.mapping.floor.grid import BARE_BELOW, CELL_M, LogOdds, Window
from protocol.geometry import Array

SEEN_ABOVE = 0.3  # log-odds: one sharp look
BARE_GAP_CELLS, HIDDEN_GAP_CELLS = 2, 4  # half of what pieces of one base may be apart: bare floor between them, or floor that is hidden
REACH_CELLS = 4  # a point so near to a cluster lies on it
LEAST_CELLS = 6
LARGE_CELLS = 60  # across: what is smaller is one thing, however it lies; a base line as long is that of a wall
SOLID_SHARE = 0.75  # of the hull around a cluster that may be anything but bare floor, from which on it is one thing
MOST_CUTS = 4

Labels = NDArray[np.int32]
Cells = NDArray[np.int_]


class Clusters(NamedTuple):
    """The clusters in a window."""

    window: Window
    labels: Labels  # shape `window.shape`: from 1, 0 where there is no base near
    cells: tuple[Cells, ...]  # of each cluster, (n, 2) rows and columns

    def at(self, points_m: Array) -> Labels:
        """Return the cluster, (n,), on which points, (n, 2) [m; arena], lie; 0: on none."""
        columns, rows = np.floor((points_m - self.window.origin_m) / CELL_M).astype(int).T
        height, width = self.labels.shape
        inside = (columns >= 0) & (columns < width) & (rows >= 0) & (rows < height)
        return np.where(inside, self.labels[rows * inside, columns * inside], 0).astype(np.int32)

    def most_at(self, points_m: Array) -> int:
        """Return the cluster on which most of some points, (n, 2) [m; arena], lie; 0 where none lies on any."""
        found = self.at(points_m)
        found = found[found > 0]
        return int(np.bincount(found).argmax()) if len(found) else 0

    def cells_of(self, cluster: int) -> Array:
        """Return the centres of a cluster's base cells, (n, 2) [m; arena]."""
        return np.asarray((self.cells[cluster - 1][:, ::-1] + 0.5) * CELL_M + self.window.origin_m)


def clusters_of(window: Window, log_odds: LogOdds) -> Clusters:
    """Return the clusters of the cells in which a base was seen, given the log-odds in the window."""
    base = (log_odds > SEEN_ABOVE).view(np.uint8)
    is_bare = log_odds < BARE_BELOW
    near, around = (np.asarray(cv2.dilate(base, _disc(gap)), np.uint8) for gap in (BARE_GAP_CELLS, HIDDEN_GAP_CELLS))
    joined = np.where(is_bare, near, around).astype(np.uint8)
    _, components, stats, _ = cv2.connectedComponentsWithStats(joined, connectivity=8, ltype=cv2.CV_32S)
    labels = np.zeros(window.shape, np.uint16)
    found: list[Cells] = []
    for component in range(1, len(stats)):
        left, top, width, height, _ = stats[component]
        place = (slice(top, top + height), slice(left, left + width))
        own = base[place] * (components[place] == component)
        if cv2.countNonZero(own) < LEAST_CELLS:
            continue
        cells = np.argwhere(own) + np.array([top, left])
        for part in _parts(cells, is_bare, MOST_CUTS):
            found.append(part)
            labels[part[:, 0], part[:, 1]] = len(found)
    return Clusters(window, cv2.dilate(labels, _disc(REACH_CELLS)).astype(np.int32), tuple(found))


def _parts(cells: Cells, is_bare: NDArray[np.bool_], cuts: int) -> Iterator[Cells]:
    """Yield the cells, (n, 2) rows and columns, of the straight parts of a cluster; all of them where it may be one thing."""
    if cuts == 0 or int(np.ptp(cells, axis=0).max()) < LARGE_CELLS or _is_solid(cells, is_bare):
        yield cells
        return
    offsets = cells - cells.mean(axis=0)
    _, axes = np.linalg.eigh(offsets.T @ offsets)
    along = offsets @ axes[:, -1]
    is_first = along < 0.0
    for half in (cells[is_first], cells[~is_first]):
        if len(half) >= LEAST_CELLS:
            yield from _parts(half, is_bare, cuts - 1)


def _is_solid(cells: Cells, is_bare: NDArray[np.bool_]) -> bool:
    """Tell whether little of the hull around some cells is bare floor."""
    low = cells.min(axis=0)
    rows, columns = cells.max(axis=0) - low + 1
    hull = np.zeros((rows, columns), np.uint8)
    cv2.fillConvexPoly(hull, cv2.convexHull((cells - low)[:, ::-1].astype(np.int32)), 1)
    bare = is_bare[low[0] : low[0] + rows, low[1] : low[1] + columns].view(np.uint8) & hull
    return cv2.countNonZero(bare) < (1.0 - SOLID_SHARE) * cv2.countNonZero(hull)


def _disc(radius: int) -> NDArray[np.uint8]:
    return np.asarray(cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * radius + 1, 2 * radius + 1)), np.uint8)
