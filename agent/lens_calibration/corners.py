"""Finding the board in one picture: several detectors on several preparations, then every corner to a fraction of a pixel.

No detector finds all: the sector-based one (Duda and Frese, "Accurate detection and localization of checkerboard corners for calibration",
BMVC 2018) holds out against noise and dim light, the square-based one (OpenCV's older) against squares that the lens bends and crowds.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from agent.lens_calibration.board import Board
from agent.lens_calibration.camera import Camera
from protocol.geometry import Array

Picture = NDArray[np.uint8]

LARGEST_PX = 1600.0  # longer side of what is searched; corners are refined in the picture as it is
SMALL_PX = 1000.0  # below it a picture is enlarged when nothing is found in it as it is, above it is made smaller
CLIP_LIMIT, TILES = 3.0, (8, 8)  # of the contrast enhancement (Zuiderveld, "Contrast limited adaptive histogram equalization", 1994)
WINDOW_SHARE, WINDOW_PX = 0.3, (2, 12)  # half a corner's window beside the way to the next corner
REFINING = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 50, 1e-4)
MOST_MOVED_SHARE = 0.5  # of the way to the next corner: refined farther than this, a corner has run to something else
_REDRAWN_PX, _REDRAWN_TO_RAD = 1000, np.radians(115.0)

_SECTORS = cv2.CALIB_CB_NORMALIZE_IMAGE
_SECTORS_THOROUGH = cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_EXHAUSTIVE
_SQUARES = cv2.CALIB_CB_ADAPTIVE_THRESH | cv2.CALIB_CB_NORMALIZE_IMAGE


class _Attempt(NamedTuple):
    """One way to search a picture."""

    prepare: Callable[[Picture], Picture]
    detect: Callable[[Picture, Board], Array | None]


def find_corners(grey: Picture, board: Board) -> Array | None:
    """Return the board's inner corners in a grey picture, (n, 2) [px], row by row; None where the whole board is not found."""
    searched, share = _searched(grey)
    for attempt in _ATTEMPTS:
        prepared = attempt.prepare(searched)
        found = attempt.detect(prepared, board)
        if found is None:
            continue
        scale = np.array(prepared.shape[::-1]) / np.array(searched.shape[::-1]) * share
        corners = refined(grey, (found + 0.5) / scale - 0.5, board)
        if corners is not None:
            return corners
    return None


def find_corners_redrawn(grey: Picture, board: Board, camera: Camera) -> Array | None:
    """Return the corners, (n, 2) [px], of a board that is found only once the lens is roughly known; None where it is not found either.

    The picture is drawn anew in stereographic projection, which keeps squares square out to the rim of the image circle.
    """
    half = 0.5 * (_REDRAWN_PX - 1)
    focal_px = half / (2.0 * np.tan(0.5 * min(_REDRAWN_TO_RAD, camera.growing_to_rad)))
    across, down = np.meshgrid(*2 * [(np.arange(_REDRAWN_PX) - half) / focal_px])
    places = camera.project(_stereographic_rays(np.stack([across, down], axis=-1).reshape(-1, 2)))
    columns, rows = places.T.reshape(2, _REDRAWN_PX, _REDRAWN_PX).astype(np.float32)
    redrawn = np.asarray(cv2.remap(grey, columns, rows, cv2.INTER_LINEAR), np.uint8)
    for attempt in _ATTEMPTS_REDRAWN:
        found = attempt.detect(attempt.prepare(redrawn), board)
        if found is not None:
            return refined(grey, camera.project(_stereographic_rays((found - half) / focal_px)), board)
    return None


def refined(grey: Picture, corners: Array, board: Board) -> Array | None:
    """Return corners (n, 2) [px] where the picture's slopes meet, each in a window as large as its neighbours allow.

    None where one of them runs away: then what was found is no board. Source: Förstner and Gülch, "A fast operator for detection and
    precise location of distinct points", 1987, as in OpenCV's cornerSubPix.
    """
    spacing_px = _spacing_px(corners, board)
    windows = np.clip(np.rint(WINDOW_SHARE * spacing_px), *WINDOW_PX).astype(int)
    moved = corners.astype(np.float32)
    for window in np.unique(windows):
        chosen = windows == window
        start = np.ascontiguousarray(moved[chosen].reshape(-1, 1, 2))
        moved[chosen] = cv2.cornerSubPix(grey, start, (int(window), int(window)), (-1, -1), REFINING)[:, 0]
    off = np.linalg.norm(moved - corners, axis=1)
    return None if np.any(off > MOST_MOVED_SHARE * spacing_px) else moved.astype(np.float64)


def _spacing_px(corners: Array, board: Board) -> Array:
    """Return how far each corner's nearest neighbour on the board is, (n,) [px]."""
    grid = corners.reshape(board.rows, board.columns, 2)
    spacing = np.full(grid.shape[:2], np.inf)
    across, down = (np.linalg.norm(np.diff(grid, axis=axis), axis=-1) for axis in (1, 0))
    for part, steps in ((np.s_[:, 1:], across), (np.s_[:, :-1], across), (np.s_[1:], down), (np.s_[:-1], down)):
        spacing[part] = np.minimum(spacing[part], steps)
    return spacing.ravel()


def _searched(grey: Picture) -> tuple[Picture, float]:
    """Return the picture, made smaller where it is very large, and the scale."""
    share = min(1.0, LARGEST_PX / max(grey.shape))
    return (grey if share == 1.0 else np.asarray(cv2.resize(grey, None, fx=share, fy=share, interpolation=cv2.INTER_AREA), np.uint8)), share


def _stereographic_rays(places: Array) -> Array:
    """Return unit rays (n, 3) [camera] of places (n, 2) on a stereographic picture of focal length one: radius = 2 tan(t / 2)."""
    radius = np.hypot(places[:, 0], places[:, 1])
    angle = 2.0 * np.arctan(0.5 * radius)
    return np.column_stack([places * (np.sin(angle) / np.maximum(radius, 1e-12))[:, None], np.cos(angle)])


def _as_it_is(grey: Picture) -> Picture:
    return grey


def _with_contrast(grey: Picture) -> Picture:
    return np.asarray(cv2.createCLAHE(CLIP_LIMIT, TILES).apply(grey), np.uint8)


def _resized(grey: Picture) -> Picture:
    if max(grey.shape) < SMALL_PX:
        return np.asarray(cv2.resize(grey, None, fx=2.0, fy=2.0, interpolation=cv2.INTER_CUBIC), np.uint8)
    return np.asarray(cv2.resize(grey, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA), np.uint8)


def _by_sectors(grey: Picture, board: Board) -> Array | None:
    return _array(cv2.findChessboardCornersSB(grey, board.size, flags=_SECTORS))


def _by_sectors_thoroughly(grey: Picture, board: Board) -> Array | None:
    return _array(cv2.findChessboardCornersSB(grey, board.size, flags=_SECTORS_THOROUGH))


def _by_squares(grey: Picture, board: Board) -> Array | None:
    return _array(cv2.findChessboardCorners(grey, board.size, flags=_SQUARES))


def _array(answer: tuple[bool, ArrayLike]) -> Array | None:
    """Return what OpenCV's detectors answer as corners (n, 2), or None."""
    is_found, corners = answer
    return np.asarray(corners, np.float64).reshape(-1, 2) if is_found else None


_ATTEMPTS = (
    _Attempt(_as_it_is, _by_sectors),
    _Attempt(_as_it_is, _by_squares),
    _Attempt(_with_contrast, _by_sectors),
    _Attempt(_with_contrast, _by_squares),
    _Attempt(_as_it_is, _by_sectors_thoroughly),
    _Attempt(_resized, _by_sectors_thoroughly),
)
_ATTEMPTS_REDRAWN = _ATTEMPTS[1], _ATTEMPTS[3], _ATTEMPTS[0]
