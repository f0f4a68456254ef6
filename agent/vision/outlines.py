"""Outlines of what stands on the floor: the border of a region, every point of it mapped onto the floor."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from agent.vision.connection import connect_pieces, fills_its_hull
from agent.vision.floor_projection import FloorProjection
from agent.vision.floor_view import FloorView
from agent.vision.hull import convex_hull
from protocol.geometry import Array

Mask = NDArray[np.uint8]

DIRECTIONS = 72  # a thing seen in each of so many goes all round
TOLERANCE_PX = 0.8  # of the view; the border is no finer than that
FINER, SHIFT_BITS = 2, 4  # parts of a pixel in which an edge is drawn to find where it crosses itself, and binary digits of its places
MARGIN_PX = 2  # a thing's own corners lie on its border, and a little outside the mask
MOST_REGIONS = 32  # in one local map


def open_rings(not_floor: Mask, view: FloorView) -> Mask:
    """Return the mask, (rows, cols), cut open behind the robot where a wall surrounds it, so that no outline encloses the robot."""
    if not all(not_floor[v, u].any() for u, v in view.rays_px):
        return not_floor
    count, components = cv2.connectedComponents(not_floor, connectivity=8)
    covered = np.flatnonzero(not_floor)
    directions = ((view.bearing_rad.ravel()[covered] + np.pi) * (DIRECTIONS / (2.0 * np.pi))).astype(np.intp) % DIRECTIONS
    seen = np.zeros((count, DIRECTIONS), np.bool_)
    seen[components.ravel()[covered], directions] = True
    rings = np.flatnonzero(seen[1:].all(axis=1)) + 1
    if not rings.size:
        return not_floor
    behind = np.abs(np.abs(view.bearing_rad) - np.pi) * view.range_m < np.maximum(0.01, 0.004 * view.range_m**2)
    return np.where(behind & np.isin(components, rings), 0, not_floor).astype(np.uint8)


@dataclass(frozen=True, eq=False)
class Borders:
    """The regions of a mask that are no specks, numbered from 1."""

    pixels: list[NDArray[np.int32]]  # per region (m, 2) u, v of its border [view px], through the centres of the outermost pixels
    compact: list[bool]  # per region: nearly convex, so that its convex hull stands for it
    numbers: Mask  # (rows, cols) which region each pixel lies in; 0: none
    edges: list[Array]  # per region (n, 2) u, v along its border [view px], where the thing ends as far as is known

    def __len__(self) -> int:
        """Count the regions."""
        return len(self.pixels)

    def near(self, pixels: Array) -> NDArray[np.int32]:
        """Return the region, (n,), that each of `pixels` (n, 2) [view px] lies in or within MARGIN_PX of; 0: none."""
        rows, cols = self.numbers.shape
        nearest = np.rint(pixels).astype(np.intp)
        inside = np.all((nearest >= 0) & (nearest < (cols, rows)), axis=1)
        u, v = (nearest * inside[:, None]).T
        return np.where(inside, self.widened[v, u], 0).astype(np.int32)

    @cached_property
    def widened(self) -> Mask:
        """`numbers` with every region grown by MARGIN_PX."""
        width = 2 * MARGIN_PX + 1
        return np.asarray(cv2.dilate(self.numbers, np.ones((width, width), np.uint8)), dtype=np.uint8)


def find_borders(not_floor: Mask, centre_px: Array, least_area_px: float) -> Borders:
    """Return the regions of a mask, (rows, cols): its components, those connected that belong together, the largest first.

    `centre_px` (2,) is the point under the camera [view px]. Holes are taken for part of a region.
    """
    contours, _ = cv2.findContours(not_floor, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    by_area = sorted(((cv2.contourArea(contour), index) for index, contour in enumerate(contours)), reverse=True)
    pieces = [contours[index][:, 0].astype(np.int32) for area, index in by_area if area >= least_area_px][:MOST_REGIONS]
    groups = connect_pieces(pieces, centre_px)
    numbers = np.zeros(not_floor.shape, np.uint8)
    for number, group in enumerate(groups, start=1):
        cv2.drawContours(numbers, [pieces[index] for index in group], -1, number, cv2.FILLED)
    pixels = [np.concatenate([pieces[index] for index in group]) for group in groups]
    compact = [fills_its_hull([pieces[index] for index in group]) for group in groups]
    return Borders(pixels, compact, numbers, [border.astype(np.float64) for border in pixels])


def floor_outlines(borders: Borders, view: FloorView, projection: FloorProjection) -> list[Array]:
    """Map all regions' edges onto the floor: per region (n, 2) [m; body], counter-clockwise, no farther out than the view reaches.

    A compact region becomes the convex hull of its points (III.5), which is exact for an upright convex thing seen from one side.
    """
    chosen = [points if compact else _simplified(points) for points, compact in zip(borders.edges, borders.compact, strict=True)]
    if not chosen:
        return []
    floor = projection.floor_from_pixels(view.camera_pixels(np.concatenate(chosen)))
    range_m = np.hypot(floor[:, 0], floor[:, 1])
    floor = floor * np.minimum(1.0, view.reach_m / np.maximum(range_m, 1e-9))[:, None]
    parts = np.split(floor, np.cumsum([len(points) for points in chosen])[:-1])
    return [
        convex_hull(part) if compact else _counter_clockwise(_finite(part)) for part, compact in zip(parts, borders.compact, strict=True)
    ]


def _simplified(edge_px: Array) -> Array:
    """Return the largest part of an edge, (n, 2) [px], without the points that tell nothing; where it crosses itself it has several."""
    first = np.floor(edge_px.min(axis=0)) - 1.0
    fine = np.rint((edge_px - first) * FINER * (1 << SHIFT_BITS)).astype(np.int32)
    cols, rows = (np.ceil((edge_px.max(axis=0) - first) * FINER) + 2.0).astype(int)
    inside = cv2.fillPoly(np.zeros((rows, cols), np.uint8), [fine], 1, lineType=cv2.LINE_8, shift=SHIFT_BITS)
    pieces, _ = cv2.findContours(inside, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    largest = max(pieces, key=cv2.contourArea)
    return np.asarray(cv2.approxPolyDP(largest, TOLERANCE_PX * FINER, True)[:, 0] / FINER + first, dtype=np.float64)


def _finite(points: Array) -> Array:
    return points[np.isfinite(points).all(axis=1)]


def _counter_clockwise(outline: Array) -> Array:
    return outline if signed_area(outline) >= 0.0 else outline[::-1]


def signed_area(polygon: Array) -> float:
    """Return the area of a polygon, (n, 2), positive when it runs counter-clockwise."""
    x, y = polygon.T
    return float(0.5 * (x[:-1] @ y[1:] - x[1:] @ y[:-1] + x[-1] * y[0] - x[0] * y[-1]))
