"""Harris corners (the paper's Eq. 2): points whose surroundings change in every direction, so that flow can follow them."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from protocol.geometry import Array

_GREY_LEVELS = 255.0
_SOBEL_GAIN = 8.0
_STRIP_ROWS = 160  # as many as fit the cache with all sums beside them: twice as fast as the whole picture at once


@dataclass(frozen=True)
class HarrisParameters:
    """What counts as a corner, and how many are wanted."""

    k: float = 0.04  # the paper's constant of Eq. 2
    window_sigma_px: float = 1.0  # of the Gaussian window W, cut at three sigma
    threshold: float = 0.01  # the paper's m, as a fraction of the picture's strongest response; 0.3 in the paper
    min_distance_px: int = 7  # a corner is the strongest within so many rows and columns
    max_corners: int = 300
    cell_px: int = 80  # when there are too many, the cells of this size take turns in giving their strongest


PAPER = HarrisParameters(threshold=0.3)


def find_corners(grey: NDArray[np.uint8], parameters: HarrisParameters, mask: NDArray[np.uint8] | None = None) -> Array:
    """Return corners, shape (n, 2) [px], in a grey picture (h, w), strongest first; only where the mask (h, w), if given, is not 0."""
    response = harris_response(grey, parameters.window_sigma_px, parameters.k)
    if mask is not None:
        response *= mask != 0
    places = np.flatnonzero(corner_map(response, parameters.threshold, parameters.min_distance_px))
    strongest_first = np.argsort(-response.ravel()[places], kind="stable")
    rows, columns = np.divmod(places[strongest_first], grey.shape[1])
    corners = np.stack([columns, rows], axis=1).astype(np.float64)
    return corners[_spread(corners, parameters.max_corners, parameters.cell_px)]


def harris_response(grey: NDArray[np.uint8], window_sigma_px: float, k: float) -> NDArray[np.float32]:
    """Return O(x, y) of Eq. 2, shape (h, w), of a grey picture (h, w) whose brightness is taken from 0 to 1."""
    height = len(grey)
    reach = _window_reach(window_sigma_px) + 1  # rows beside a strip that its answer depends on: the window's, and the gradient's
    response = np.empty(grey.shape, np.float32)
    for top in range(0, height, _STRIP_ROWS):
        above, bottom = max(top - reach, 0), min(top + _STRIP_ROWS, height)
        strip = _strip_response(grey[above : bottom + reach], window_sigma_px, k)
        response[top:bottom] = strip[top - above : bottom - above]
    return response


def corner_map(response: NDArray[np.float32], threshold: float, min_distance_px: int) -> NDArray[np.bool_]:
    """Return HCM(x, y) of Eq. 2, shape (h, w), thinned out to the strongest response within `min_distance_px` rows and columns.

    A corner has a positive response above `threshold` times the strongest.
    """
    size = 2 * min_distance_px + 1
    strongest_near = cv2.dilate(response, np.ones((size, size), np.uint8))
    return np.asarray((response >= strongest_near) & (response > max(threshold * float(response.max(initial=0.0)), 0.0)))


def _strip_response(grey: NDArray[np.uint8], window_sigma_px: float, k: float) -> NDArray[np.float32]:
    """Return O(x, y), shape (rows, w), of one strip (rows, w); near its upper and lower border the picture is taken to be mirrored."""
    scale = 1.0 / (_GREY_LEVELS * _SOBEL_GAIN)
    i_x = cv2.Sobel(grey, cv2.CV_32F, 1, 0, scale=scale)
    i_y = cv2.Sobel(grey, cv2.CV_32F, 0, 1, scale=scale)
    # C(x, y), the change of brightness summed over the window; results take the place of what is no longer needed.
    c_xy = _window_sum(i_x * i_y, window_sigma_px)
    c_xx = _window_sum(np.square(i_x, out=i_x), window_sigma_px)
    c_yy = _window_sum(np.square(i_y, out=i_y), window_sigma_px)
    trace = c_xx + c_yy
    response = np.multiply(c_xx, c_yy, out=c_xx)
    response -= np.square(c_xy, out=c_xy)
    response -= np.multiply(np.square(trace, out=trace), k, out=trace)
    return response


def _window_sum(values: NDArray[np.float32], sigma_px: float) -> NDArray[np.float32]:
    """Sum over the Gaussian window, in place."""
    size = 2 * _window_reach(sigma_px) + 1
    return np.asarray(cv2.GaussianBlur(values, (size, size), sigma_px, dst=values), dtype=np.float32)


def _window_reach(sigma_px: float) -> int:
    return int(np.ceil(3.0 * sigma_px))


def _spread(corners: Array, count: int, cell_px: int) -> NDArray[np.intp]:
    """Choose at most `count` of corners (n, 2) given strongest first: the best of every cell, then the second best, and so on."""
    if len(corners) <= count:
        return np.arange(len(corners))
    columns, rows = (corners // cell_px).astype(np.int64).T
    cell = rows * (columns.max() + 1) + columns
    by_cell = np.argsort(cell, kind="stable")
    _, first, sizes = np.unique(cell[by_cell], return_index=True, return_counts=True)
    rank = np.empty(len(cell), dtype=np.int64)
    rank[by_cell] = np.arange(len(cell)) - np.repeat(first, sizes)
    return np.sort(np.argsort(rank, kind="stable")[:count])
