"""Where the edge between two surfaces lies in a picture, found in its gradients along a known outline, to a part of a pixel."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from protocol.geometry import Array

STEP_PX = 3.0  # between samples along an outline
REACH_PX, FINE_PX = 6.0, 0.25  # of the profile along the normal, on both sides, and between its points
BLUR_PX = 1.0
ALONG = 7  # samples over which the gradient is averaged along the outline
ASIDE_PX = 3.0  # inwards and outwards, where a sample belongs to its thing and to what is behind
LEAST_STEP = 8.0  # grey levels per pixel: a weaker edge is no edge


def samples(outline_px: Array) -> tuple[Array, Array]:
    """Return points along a closed outline, (n, 2) [px], and the normals of the outline there, (n, 2), inwards."""
    edge = np.roll(outline_px, -1, axis=0) - outline_px
    length = np.hypot(*edge.T)
    way = np.concatenate([[0.0], np.cumsum(length)])
    at = np.arange(0.5 * STEP_PX, way[-1], STEP_PX)
    of = np.minimum(np.searchsorted(way, at, side="right") - 1, len(edge) - 1)
    along = edge[of] / np.maximum(length[of], 1e-9)[:, None]
    points = outline_px[of] + (at - way[of])[:, None] * along
    return points, np.stack([along[:, 1], -along[:, 0]], axis=-1)


def edge_offsets(picture: NDArray[np.uint8], points: Array, normals: Array) -> Array:
    """Return how far along its normal from each point the steepest change of colour lies, (n,) [px]; NaN where there is none.

    The steepest place is the vertex of a parabola through the steepest three. What crosses the outline averages out along it.
    """
    offsets = np.arange(-REACH_PX, REACH_PX + FINE_PX / 2, FINE_PX)
    where = (points[:, None] + offsets[:, None] * normals[:, None]).astype(np.float32)
    blurred = cv2.GaussianBlur(picture, (0, 0), BLUR_PX).astype(np.float32)
    profile = cv2.remap(blurred, where[..., 0], where[..., 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    change = cv2.GaussianBlur(cv2.Sobel(profile, cv2.CV_32F, 1, 0, ksize=1, scale=0.5 / FINE_PX), (5, 1), 0)
    slope = np.sqrt((np.asarray(cv2.blur(change, (1, ALONG))) ** 2).sum(axis=2))
    best = slope[:, 1:-1].argmax(axis=1) + 1
    before, top, after = (slope[np.arange(len(points)), best + side] for side in (-1, 0, 1))
    vertex = 0.5 * (before - after) / np.minimum(before - 2.0 * top + after, -1e-9)
    is_edge = (top >= LEAST_STEP) & (best > 1) & (best < slope.shape[1] - 2)
    return np.where(is_edge, offsets[best] + FINE_PX * np.clip(vertex, -1.0, 1.0), np.nan)


def visible(outlines_px: list[Array], size_px: tuple[int, int]) -> list[tuple[Array, Array]]:
    """Return the samples of each outline, given from the farthest to the nearest, where no nearer thing hides what is on either side."""
    owner = np.zeros(size_px[::-1], np.uint8)
    for number, outline_px in enumerate(outlines_px, start=1):
        cv2.fillPoly(owner, [np.rint(outline_px).astype(np.int32)], number)
    seen = []
    for number, outline_px in enumerate(outlines_px, start=1):
        points, normals = samples(outline_px)
        within, beyond = (_at(owner, points + side * ASIDE_PX * normals) for side in (1.0, -1.0))
        is_free = (within == number) & (beyond < number)
        seen.append((points[is_free], normals[is_free]))
    return seen


def _at(picture: NDArray[np.uint8], points: Array) -> NDArray[np.uint8]:
    u, v = np.clip(np.rint(points).astype(int), 0, np.array(picture.shape[1::-1]) - 1).T
    return np.asarray(picture[v, u])
