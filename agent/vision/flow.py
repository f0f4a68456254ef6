"""Lucas-Kanade optical flow: where points of one picture are in the next.

`lucas_kanade` is Eq. 3 to 5 of the paper written out, on one level, and serves as the reference; `track_pyramidal` is OpenCV's
implementation over a pyramid, checked forwards and backwards.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from agent.vision.robust import median
from protocol.geometry import Array

_GREY_LEVELS = 255.0
EVERY_PX = 8  # of either direction tells the exposure
DARKEST, BRIGHTEST = 8.0, 247.0  # grey levels that the sensor has not cut off
LEAST_TOLD = 0.05  # of the pixels that are looked at
LEAST_CHANGE = 0.03  # a smaller one does flow no harm
_SCHARR_GAIN = 32.0


@dataclass(frozen=True)
class FlowParameters:
    """How flow is followed; the defaults are for points whose ends are predicted to a few pixels."""

    window_px: int = 17  # side of the square window, odd
    levels: int = (
        1  # pyramid levels above the picture itself: more of them see more of a repeating floor, and mistake one tile for the next
    )
    max_steps: int = 30
    min_step_px: float = 0.01  # a point that moves less than this has arrived
    max_round_trip_px: float = 0.5  # farthest from its start that a point may return to when followed backwards
    min_texture: float = 1e-6  # least eigenvalue of Eq. 5's matrix per pixel of the window, brightness from 0 to 1


@dataclass(frozen=True, eq=False)
class Flow:
    """Where n points went. A point that is not kept was lost; its end is then the best guess there is."""

    ends_px: Array  # (n, 2)
    kept: NDArray[np.bool_]  # (n,)


def lucas_kanade(
    previous: NDArray[np.uint8], current: NDArray[np.uint8], starts_px: Array, predicted_px: Array, parameters: FlowParameters
) -> Flow:
    """Follow points, shape (n, 2) [px], between two grey pictures (h, w) by Eq. 5, repeated until each point rests.

    Every step starts from where the last one ended, first from `predicted_px` (n, 2), so that the linearised Eq. 3 holds.
    Kept are points with enough texture that stay inside the picture.
    """
    starts, ends, finite = _usable(starts_px, predicted_px)
    offsets, weights = _gaussian_window(parameters.window_px)
    brightness = previous.astype(np.float64)[..., None] / _GREY_LEVELS
    patch = _sample(np.concatenate([brightness, _gradient(previous)], axis=-1), starts, offsets)
    inverse, textured = _invert(np.einsum("m,nmi,nmj->nij", weights, patch[..., 1:], patch[..., 1:]), parameters.min_texture)
    target = current.astype(np.float64)[..., None] / _GREY_LEVELS
    moving = np.flatnonzero(textured & finite & _inside(ends, current))
    for _ in range(parameters.max_steps):
        if not moving.size:
            break
        i_t = _sample(target, ends[moving], offsets)[..., 0] - patch[moving, :, 0]
        right_side = -np.einsum("m,nmi,nm->ni", weights, patch[moving, :, 1:], i_t)
        step = np.einsum("nij,nj->ni", inverse[moving], right_side)  # Eq. 5
        ends[moving] += step
        moving = moving[(np.hypot(step[:, 0], step[:, 1]) > parameters.min_step_px) & _inside(ends[moving], current)]
    return Flow(ends, textured & finite & _inside(ends, current))


def track_pyramidal(
    previous: NDArray[np.uint8], current: NDArray[np.uint8], starts_px: Array, predicted_px: Array, parameters: FlowParameters
) -> Flow:
    """Follow points, shape (n, 2) [px], between two grey pictures (h, w), starting at `predicted_px` (n, 2), and back again.

    The way back starts from the same prediction reversed, not from the known start, which would make the check agree with itself.
    Kept are points that OpenCV could follow both ways, that end inside the picture and return to within `max_round_trip_px`.
    """
    starts, predicted, finite = _usable(starts_px, predicted_px)
    ends, found = _follow(previous, current, starts, predicted, parameters)
    returns, found_back = _follow(current, previous, ends, ends - (predicted - starts), parameters)
    round_trip = np.hypot(*(returns - starts).T)
    kept = finite & found & found_back & (round_trip <= parameters.max_round_trip_px) & _inside(ends, current)
    return Flow(ends, kept)


def as_bright(previous: NDArray[np.uint8], current: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return a grey picture (h, w), a moment ago, at the exposure of the current one: flow takes every change of brightness for motion.

    Most of what either shows is the same floor, so the median ratio of their pixels is that of their exposures.
    """
    before, now = (picture[::EVERY_PX, ::EVERY_PX].astype(np.float64) for picture in (previous, current))
    told = (np.minimum(before, now) > DARKEST) & (np.maximum(before, now) < BRIGHTEST)
    gain = float(median(now[told] / before[told])) if np.count_nonzero(told) > LEAST_TOLD * told.size else 1.0
    if abs(gain - 1.0) < LEAST_CHANGE:
        return previous
    return np.asarray(cv2.convertScaleAbs(previous, alpha=gain), np.uint8)


def _follow(
    previous: NDArray[np.uint8], current: NDArray[np.uint8], starts: Array, predicted: Array, parameters: FlowParameters
) -> tuple[Array, NDArray[np.bool_]]:
    """Return the ends, shape (n, 2) [px], and which of them OpenCV found."""
    if not len(starts):
        return starts.copy(), np.zeros(0, dtype=np.bool_)
    ends, found, _ = cv2.calcOpticalFlowPyrLK(
        previous,
        current,
        starts.astype(np.float32),
        predicted.astype(np.float32),
        winSize=(parameters.window_px, parameters.window_px),
        maxLevel=parameters.levels,
        criteria=(cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, parameters.max_steps, parameters.min_step_px),
        flags=cv2.OPTFLOW_USE_INITIAL_FLOW,
        minEigThreshold=parameters.min_texture,
    )
    return ends.astype(np.float64), found.ravel() != 0


def _usable(starts_px: Array, predicted_px: Array) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Return copies in which a point without a finite prediction stays where it is, and which points have one."""
    starts = np.array(starts_px, dtype=np.float64).reshape(-1, 2)
    predicted = np.array(predicted_px, dtype=np.float64).reshape(-1, 2)
    finite = np.isfinite(np.concatenate([starts, predicted], axis=1)).all(axis=1)
    starts = np.nan_to_num(starts, posinf=0.0, neginf=0.0)
    return starts, np.where(finite[:, None], predicted, starts), finite


def _gaussian_window(window_px: int) -> tuple[Array, Array]:
    """Return the window's offsets, shape (m, 2) [px], and the weights omega_i of Eq. 5, shape (m,), of sum 1.

    Sigma is a quarter of the side, so that the border of the window counts a seventh of its middle.
    """
    reach = np.arange(window_px) - 0.5 * (window_px - 1)
    offsets = np.stack(np.meshgrid(reach, reach), axis=-1).reshape(-1, 2)
    weights = np.exp(-0.5 * (offsets**2).sum(axis=1) / (0.25 * window_px) ** 2)
    return offsets, weights / weights.sum()


def _gradient(grey: NDArray[np.uint8]) -> Array:
    """Return I_x and I_y, shape (h, w, 2) [brightness / px]."""
    scale = 1.0 / (_GREY_LEVELS * _SCHARR_GAIN)
    return np.stack([cv2.Scharr(grey, cv2.CV_64F, 1, 0, scale=scale), cv2.Scharr(grey, cv2.CV_64F, 0, 1, scale=scale)], axis=-1)


def _invert(matrices: Array, min_eigenvalue: float) -> tuple[Array, NDArray[np.bool_]]:
    """Invert symmetric matrices, shape (n, 2, 2); the second result, shape (n,), says where the least eigenvalue allows it."""
    a, b, c = matrices[:, 0, 0], matrices[:, 0, 1], matrices[:, 1, 1]
    least = 0.5 * (a + c) - np.hypot(0.5 * (a - c), b)
    textured = least > min_eigenvalue
    determinant = np.where(textured, a * c - b * b, 1.0)
    adjugate = np.stack([np.stack([c, -b], axis=-1), np.stack([-b, a], axis=-1)], axis=-2)
    return adjugate / determinant[:, None, None], textured


def _sample(values: Array, centres: Array, offsets: Array) -> Array:
    """Read an array (h, w, c) at centres (n, 2) + offsets (m, 2) [px], bilinearly: (n, m, c); beyond the border the border goes on."""
    height, width = values.shape[:2]
    x, y = np.moveaxis(np.clip(centres[:, None] + offsets, 0.0, (width - 1.0, height - 1.0)), -1, 0)
    column, row = np.minimum(x.astype(np.intp), width - 2), np.minimum(y.astype(np.intp), height - 2)
    right, down = (x - column)[..., None], (y - row)[..., None]
    above = values[row, column] * (1.0 - right) + values[row, column + 1] * right
    below = values[row + 1, column] * (1.0 - right) + values[row + 1, column + 1] * right
    return np.asarray(above * (1.0 - down) + below * down)


def _inside(points: Array, picture: NDArray[np.uint8]) -> NDArray[np.bool_]:
    """Tell which points, shape (n, 2) [px], lie within the picture (h, w)."""
    height, width = picture.shape[:2]
    return np.asarray((points >= 0.0).all(axis=1) & (points <= (width - 1.0, height - 1.0)).all(axis=1))
