"""The outline of an upright prism as an eye sees it, and which of a picture's pixels it covers, and how far."""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from protocol.geometry import Array

PIECE_RAD = 0.05  # edges are cut into pieces that an eye sees under at most this angle, since they are curved in the picture
NEAREST_M = 0.2  # no edge is taken as nearer to the eye
_MOST_PIECES = 32
_SHIFT_BITS = 4


class Coverage(NamedTuple):
    """Part of a canvas, and how far each of its pixels is covered, 0 to 1."""

    rows: slice
    cols: slice
    alpha: NDArray[np.float32]


def facing(footprint: Array, eye: Array) -> NDArray[np.bool_]:
    """Tell of each edge i, i + 1 of a counter-clockwise footprint, (n, 2), whether its outer side faces the eye, (2,)."""
    edge = following(footprint) - footprint
    to_eye = eye - footprint
    return np.asarray(edge[:, 1] * to_eye[:, 0] - edge[:, 0] * to_eye[:, 1] > 0.0)


def outline(footprint: Array, height_m: float, eye: Array) -> Array | None:
    """Return the closed outline, (m, 3) [m], of a prism on the floor from an eye, (3,); None from within it.

    It runs along the base of the sides that face the eye, and back along the top: behind, where the eye looks down on that.
    """
    ring, sides = _from_first_side(footprint, eye)
    if sides == 0:
        return _in_pieces(_at(ring, height_m), eye)[:-1] if height_m < eye[2] else None
    near = ring[: sides + 1]
    back = ring[sides:] if height_m < eye[2] else near[::-1]
    loop = np.concatenate([_at(near, 0.0), _at(back, height_m), _at(near[:1], 0.0)])
    return _in_pieces(loop, eye)[:-1]


def both_ways(footprint: Array, eye: Array) -> tuple[Array, Array]:
    """Return the way round a footprint on the sides that face an eye, (n, 2), and the way back behind, (m, 2), in short pieces.

    From within the footprint the first one is a point.
    """
    ring, sides = _from_first_side(footprint, eye)
    near, behind = (_in_pieces(_at(way, 0.0), eye)[:, :2] for way in (ring[: sides + 1], ring[sides:]))
    return near, behind


def coverage(pixels: Array, canvas: tuple[int, int]) -> Coverage | None:
    """Return what an outline, (m, 2) u, v [px], covers of a canvas of (rows, cols), exactly; None where that is nothing.

    The area to the right of every edge is added up with the edge's sign, as in the scan conversion of fonts: an edge puts what it
    cuts off into the pixels that it crosses, and the sum along a row carries it on.
    """
    corners = pixels + 0.5  # pixel i now reaches from i to i + 1
    left, top = np.maximum(np.floor(corners.min(axis=0)).astype(int), 0).tolist()
    right, bottom = np.minimum(np.ceil(corners.max(axis=0)).astype(int), canvas[::-1]).tolist()
    width, height = right - left, bottom - top
    if width < 1 or height < 1:
        return None
    start = _at_pixel_borders(corners - (left, top))
    end = following(start)
    middle = 0.5 * (start + end)
    cell = np.floor(middle).astype(np.intp)
    used = (cell[:, 1] >= 0) & (cell[:, 1] < height) & (cell[:, 0] < width)
    cell, down = cell[used], (end - start)[used, 1]
    beside = down * np.where(cell[:, 0] < 0, 0.0, middle[used, 0] - cell[:, 0])
    index = cell[:, 1] * (width + 1) + np.maximum(cell[:, 0], 0)
    size = height * (width + 1)
    change = np.bincount(index, down - beside, size) + np.bincount(index + 1, beside, size)
    area = np.abs(np.cumsum(change.reshape(height, width + 1)[:, :width], axis=1))
    return Coverage(slice(top, bottom), slice(left, right), np.minimum(area, 1.0).astype(np.float32))


def blend(canvas: NDArray[np.uint8], where: Coverage, colours: NDArray[np.uint8]) -> None:
    """Lay colours, (rows, cols, 3), over the covered part of a canvas."""
    part = canvas[where.rows, where.cols]
    part[:] = cv2.blendLinear(part, colours, 1.0 - where.alpha, where.alpha)


def fill(canvas: NDArray[np.uint8], pixels: Array, bgr: tuple[int, ...]) -> None:
    """Fill an outline, (m, 2) u, v [px], with one colour: to half a pixel, where `coverage` and `blend` would take too long."""
    cv2.fillPoly(canvas, [np.rint(pixels * (1 << _SHIFT_BITS)).astype(np.int32)], bgr, cv2.LINE_8, _SHIFT_BITS)


def following(points: Array) -> Array:
    """Return each point's successor in a closed ring, (n, d)."""
    return np.concatenate([points[1:], points[:1]])


def _from_first_side(footprint: Array, eye: Array) -> tuple[Array, int]:
    """Return the closed ring, (n + 1, 2), from where the sides that face the eye begin, and how many those are."""
    visible = facing(footprint, eye[:2])
    sides = int(visible.sum())
    first = int(np.argmax(visible & ~np.concatenate([visible[-1:], visible[:-1]])))
    return np.concatenate([footprint[first:], footprint[: first + 1]]), sides


def _at(points: Array, height_m: float) -> Array:
    return np.column_stack([points, np.full(len(points), height_m)])


def _in_pieces(way: Array, eye: Array) -> Array:
    """Cut the edges of a way, (n, 3), into pieces that are short to the eye."""
    edge = way[1:] - way[:-1]
    away = way[:-1] + 0.5 * edge - eye
    length, away_m = np.sqrt((edge * edge).sum(axis=1)), np.sqrt((away * away).sum(axis=1))
    nearest_m = np.maximum(away_m - 0.5 * length, NEAREST_M)
    pieces = np.minimum(np.ceil(length / (PIECE_RAD * nearest_m) + 1e-9), _MOST_PIECES).astype(int)
    of, step = _repeats(pieces)
    return np.concatenate([way[of] + (step / pieces[of])[:, None] * edge[of], way[-1:]])


def _repeats(counts: NDArray[np.intp]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return indices 0, 0, ... 1, 1, ... each so many times, and the number of each within its own."""
    of = np.repeat(np.arange(len(counts)), counts)
    return of, np.arange(len(of)) - (np.cumsum(counts) - counts)[of]


def _at_pixel_borders(ring: Array) -> Array:
    """Return a closed ring, (n, 2), with further points wherever one of its coordinates is a whole number."""
    way = following(ring) - ring
    begin, along = ring.T.ravel(), way.T.ravel()
    first, last = np.floor(begin), np.floor(begin + along)
    of, step = _repeats(np.abs(last - first).astype(np.intp))
    line = np.where(along > 0.0, first + 1.0, first)[of] + np.copysign(step, along[of])
    edges = len(ring)
    where = np.sort(np.concatenate([np.arange(edges), of % edges + (line - begin[of]) / along[of]]))  # edge, and the share of its way
    edge = np.minimum(where.astype(np.intp), edges - 1)
    return np.asarray(ring[edge] + (where - edge)[:, None] * way[edge])
