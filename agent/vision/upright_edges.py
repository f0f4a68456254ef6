"""Upright edges of what stands around: in a picture laid out by bearing and by angle from straight down, they keep their bearing.

An upright edge and the camera lie in a plane that holds the vertical. So where the vertical is d off across the edge, the bearing under
which the edge is seen changes with the cotangent of the angle, by d (a great circle's equation; Barnard, "Interpreting perspective images",
1983, on vanishing points by Gaussian sphere). Edges that lie flat point at the spot under the camera by chance only.
"""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from agent.vision.floor_projection import FloorProjection
from agent.vision.remap_table import RemapTable
from protocol.geometry import Array

Picture = NDArray[np.uint8]
Field = NDArray[np.float32]

COLUMNS, NODES = 2048, 256  # all round; so many are asked of the lens, and all between is interpolated
NEAREST_RAD, FARTHEST_RAD = 0.63, 1.6  # from straight down: beyond the own body, and up to the horizon
ROW_RAD, ROWS_PER_BAND = 0.007, 5  # rows are averaged over a band, in which an edge is followed as one place
STEEP_SHARE, LEAST_STEP = 6.0, 1.5  # of the picture's median slope, and in grey levels over two columns: what counts as an edge
LINK_COLUMNS = 1.5  # by which an edge may leave its bearing from one band to the next: over a degree of tilt
LEAST_BANDS = 4  # that an edge has to cross
STRAIGHT_COLUMNS = 0.5  # rms by which it may leave a straight line
PLACE_COLUMNS = 0.25  # to which its place in one band is known
SLOPE = 0.25 * np.array([[-1.0, -2.0, 0.0, 2.0, 1.0]], np.float32)  # over two columns, smoothed by [1 2 1] / 4
PAD = 2
STRIDE = 16  # between the columns of which the median slope is taken
COLUMN_RAD = 2.0 * np.pi / COLUMNS


class UprightEdges(NamedTuple):
    """Edges that are upright, or nearly so, n of them."""

    bearing_rad: Array  # (n,) from the body's x axis
    slant_rad: Array  # (n,) change of the bearing with the cotangent of the angle from straight down
    sigma_rad: Array  # (n,) of the slant
    first: NDArray[np.intp]  # (n,) band in which the edge begins ...
    last: NDArray[np.intp]  # ... and ends


class _Points(NamedTuple):
    """Places of edges, k of them, in bands."""

    edge: NDArray[np.intp]  # (k,) whose place it is
    band: NDArray[np.intp]
    column: Array


class UprightView:
    """What is seen around the vertical, as a camera is taken to sit."""

    def __init__(self, projection: FloorProjection, height_px: int, readout_s: float) -> None:
        """Take the pictures' height, and the time from their first row to the last."""
        bands = int((FARTHEST_RAD - NEAREST_RAD) / (ROWS_PER_BAND * ROW_RAD))
        nodes_rad: Array = NEAREST_RAD + ROWS_PER_BAND * ROW_RAD * np.arange(bands + 1, dtype=np.float64)
        rays = bearing_rays(nodes_rad, np.linspace(0.0, 2.0 * np.pi, NODES + 1))
        pixels = projection.lens.project(rays @ projection.body_from_camera[:3, :3]).astype(np.float32)
        finer = np.asarray(cv2.resize(pixels, None, fx=COLUMNS // NODES, fy=ROWS_PER_BAND, interpolation=cv2.INTER_LINEAR), np.float32)
        # Where cv2.resize puts the first node: on a row, since their number between nodes is odd, and half a column before one.
        top, left = ROWS_PER_BAND // 2, COLUMNS // NODES // 2
        finer = finer[top : top + bands * ROWS_PER_BAND, left : left + COLUMNS]
        self._table = RemapTable(finer)
        self._first_rad = 0.5 * COLUMN_RAD
        self._bands = bands
        self.angles_rad: Array = nodes_rad[:-1] + top * ROW_RAD  # of the bands' middles
        self._cotangents = 1.0 / np.tan(self.angles_rad)
        rows_px = np.nan_to_num(finer[top::ROWS_PER_BAND, :, 1], nan=-1.0).astype(np.float64)
        self._late_s = (rows_px - 0.5 * (height_px - 1)) / height_px * readout_s

    def edges(self, grey: Picture, turn_rad_s: float) -> UprightEdges:
        """Return the upright edges of a camera picture, (rows, cols) grey, that was taken while the body turned."""
        around = self._table.sample(grey).astype(np.float32)
        bands = cv2.resize(around, (COLUMNS, self._bands), interpolation=cv2.INTER_AREA)
        points = _linked(*_places(np.asarray(bands, np.float32)))
        late_s = self._late_s[points.band, np.rint(points.column).astype(int) % COLUMNS]
        return self._fitted(points, COLUMN_RAD * points.column + self._first_rad + turn_rad_s * late_s)

    def _fitted(self, points: _Points, bearings_rad: Array) -> UprightEdges:
        """Return straight lines, bearing over cotangent, through the places of each edge, where these are straight."""
        x = self._cotangents[points.band]

        def total(values: Array) -> Array:
            return np.bincount(points.edge, values).astype(np.float64)

        count = total(np.ones(len(x)))
        mean_x, mean_y = total(x) / count, total(bearings_rad) / count
        dx, dy = x - mean_x[points.edge], bearings_rad - mean_y[points.edge]
        spread = total(dx * dx) + 1e-12
        slant = total(dx * dy) / spread
        rms = np.sqrt(total((dy - slant[points.edge] * dx) ** 2) / np.maximum(count - 2.0, 1.0))
        kept = (count >= LEAST_BANDS) & (rms < STRAIGHT_COLUMNS * COLUMN_RAD)
        first = np.full(len(count), self._bands)
        np.minimum.at(first, points.edge, points.band)
        last = first + count.astype(np.intp) - 1
        sigma = PLACE_COLUMNS * COLUMN_RAD / np.sqrt(spread)
        return UprightEdges(mean_y[kept], slant[kept], sigma[kept], first[kept], last[kept])


def bearing_rays(angles_rad: Array, bearings_rad: Array) -> Array:
    """Return unit rays, (rows, cols, 3) [body], at angles from straight down, (rows,), and bearings, (cols,)."""
    angle, turn = np.meshgrid(angles_rad, bearings_rad, indexing="ij")
    return np.stack([np.sin(angle) * np.cos(turn), np.sin(angle) * np.sin(turn), -np.cos(angle)], axis=-1)


def _places(bands: Field) -> tuple[NDArray[np.intp], NDArray[np.bool_], Array]:
    """Return band, whether it grows brighter, and column of every place where the bands, (bands, columns), are steepest along a row."""
    around = np.hstack([bands[:, -PAD:], bands, bands[:, :PAD]])
    smooth = cv2.filter2D(around, cv2.CV_32F, SLOPE)[:, PAD:-PAD]
    steep = np.abs(smooth)
    least = max(STEEP_SHARE * float(np.median(steep[:, ::STRIDE])), LEAST_STEP)
    band, column = np.nonzero(steep > least)
    left, at, right = (steep[band, (column + step) % COLUMNS] for step in (-1, 0, 1))
    peak = (at >= left) & (at > right)
    band, column, left, at, right = (values[peak] for values in (band, column, left, at, right))
    return band, smooth[band, column] > 0.0, column + 0.5 * (left - right) / np.minimum(left - 2.0 * at + right, -1e-6)


def _linked(band: NDArray[np.intp], brighter: NDArray[np.bool_], column: Array) -> _Points:
    """Return the places with the edge that each belongs to: those of neighbouring bands that are nearest to each other make one."""
    edge, unwrapped = np.arange(len(band)), column.copy()
    starts = np.searchsorted(band, np.arange(band.max(initial=0) + 2))
    for lower, upper, end in zip(starts[:-2], starts[1:-1], starts[2:], strict=True):
        if lower == upper or upper == end:
            continue
        apart = column[upper:end][None] - column[lower:upper][:, None]
        apart -= COLUMNS * np.rint(apart / COLUMNS)
        off = np.abs(apart) + COLUMNS * (brighter[lower:upper][:, None] != brighter[upper:end][None])
        nearest, back = off.argmin(axis=1), off.argmin(axis=0)
        here = np.flatnonzero((back[nearest] == np.arange(upper - lower)) & (off.min(axis=1) < LINK_COLUMNS))
        there = nearest[here]
        edge[upper + there] = edge[lower + here]
        unwrapped[upper + there] = unwrapped[lower + here] + apart[here, there]
    return _Points(np.unique(edge, return_inverse=True)[1], band, unwrapped)
