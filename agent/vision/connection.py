"""Region connection around the robot: Algorithm 1 on the unrolled picture, bearing across and radius up.

In a downward fisheye picture things stand along the radius, so the boxes that Algorithm 1 compares are taken along and across it: then a
wall that runs round the rim does not enclose the whole room, as its rectangle in the picture would.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from agent.vision.labels import connect_rectangles
from protocol.geometry import Array

Pixels = NDArray[np.int32]

FULLNESS = 0.8  # of the convex hull of a region, in the picture; with less it is several things, or a wall
_STEPS_PER_RAD = 200  # boxes are compared to a third of a degree
WALL_RAD = 0.5 * np.pi  # what spans more is a wall, and is connected with nothing


def connect_pieces(pieces: list[Pixels], centre_px: Array) -> list[list[int]]:
    """Return groups of pieces that belong together, given the border of each, (m, 2) u, v [px], each group led by its first piece.

    Pieces whose boxes overlap or contain each other are one thing, if together they fill their hull; a lone piece is a group of its own.
    """
    if not pieces:
        return []
    spans = _spans(pieces, centre_px)
    narrow = np.flatnonzero(spans[:, 1] - spans[:, 0] < WALL_RAD)
    group_of = np.arange(len(pieces))
    if narrow.size:
        group_of[narrow] = len(pieces) + connect_rectangles(_boxes(spans[narrow]))[1]
    groups = [[int(i) for i in np.flatnonzero(group_of == group)] for group in dict.fromkeys(group_of.tolist())]
    return [part for group in groups for part in _split(group, pieces)]


def fills_its_hull(pieces: list[Pixels]) -> bool:
    """Tell whether the pieces, each (m, 2) [px], cover most of the convex hull around all of them."""
    hull = cv2.convexHull(np.concatenate(pieces)[:, None])
    return sum(cv2.contourArea(piece[:, None]) for piece in pieces) > FULLNESS * cv2.contourArea(hull)


def _split(group: list[int], pieces: list[Pixels]) -> list[list[int]]:
    """Return the group as it is if it fills its hull, else its pieces one by one."""
    if len(group) == 1 or fills_its_hull([pieces[index] for index in group]):
        return [group]
    return [[index] for index in group]


def _spans(pieces: list[Pixels], centre_px: Array) -> Array:
    """Return first and last direction [rad], counted on from a piece's own middle, and least and greatest radius [px], (pieces, 4)."""
    sizes = np.array([len(piece) for piece in pieces])
    firsts = np.cumsum(sizes) - sizes
    offset = np.concatenate(pieces) - centre_px
    towards = np.add.reduceat(offset, firsts)
    middle = np.arctan2(towards[:, 1], towards[:, 0])
    turn = (np.arctan2(offset[:, 1], offset[:, 0]) - np.repeat(middle, sizes) + np.pi) % (2.0 * np.pi) - np.pi
    radius = np.hypot(offset[:, 0], offset[:, 1])
    least_turn, least_radius = (np.minimum.reduceat(values, firsts) for values in (turn, radius))
    most_turn, most_radius = (np.maximum.reduceat(values, firsts) for values in (turn, radius))
    return np.column_stack([middle + least_turn, middle + most_turn, least_radius, most_radius])


def _boxes(spans: Array) -> NDArray[np.int32]:
    """Return the boxes, (n, 4), of spans (n, 4), unrolled at the widest gap between them so that none is cut in two."""
    first = np.sort(spans[:, 0] % (2.0 * np.pi))
    gaps = np.diff(first, append=first[0] + 2.0 * np.pi)
    start = first[(int(np.argmax(gaps)) + 1) % len(first)]
    left = (spans[:, 0] - start) % (2.0 * np.pi) * _STEPS_PER_RAD
    width = np.maximum((spans[:, 1] - spans[:, 0]) * _STEPS_PER_RAD, 1.0)
    height = np.maximum(spans[:, 3] - spans[:, 2], 1.0)
    return np.stack([left, spans[:, 2], width, height], axis=-1).astype(np.int32)
