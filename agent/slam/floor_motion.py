"""The robot's own motion from the floor's texture: direct alignment of the newest picture with a keyframe.

Points of the keyframe where the texture has structure are looked for in the newest patch, all under one rigid motion, by Gauss-Newton on
their differences (inverse compositional: Baker and Matthews, "Lucas-Kanade 20 years on", IJCV 2004, section 3.2) with robust weights,
started from and held by what the wheels say. No feature is matched, so a regular grid does no harm as long as the wheels are right to
half a mesh.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from agent.vision.floor_patch import Field, FloorPatch
from agent.vision.robust import robust_sigma
from protocol.geometry import Array, Pose2

POINTS = 3000
COARSE_POINTS = 1000
COARSE_STEP = 3  # cells per coarse cell; its basin of attraction is that much wider
MAX_ROUNDS = 12
SETTLED, COARSE_SETTLED = 2e-5, 2e-4  # [m, rad] a step below this ends the iteration
LEAST_CORRELATION = 0.35  # below this the patches do not show the same floor
CORRELATED_POINTS = 12.0  # neighbouring points see the same grain: that many count as one
SLIP_TURNS_RAD = np.arange(-0.24, 0.25, 0.06)  # turns tried beside the wheels' when these have slipped; the coarse basin spans the steps
SLIP_INFORMATION: Array = np.diag([0.05**-2, 0.05**-2, 0.2**-2])  # ... and how far off they may be in one step [m, m, rad]
FLOOR_SIGMA = np.array([1e-4, 1e-4, 1e-4])  # [m, m, rad] what no alignment is better than: calibration, pixel borders


@dataclass(frozen=True, eq=False)
class Texture:
    """Points of a keyframe to be found again, and how their values change with motion."""

    points_m: Array  # (n, 2) [keyframe body]
    values: Array  # (n,)
    slopes: Array  # (n, 3) change of the value with x [1/m], y [1/m] and theta [1/rad] of the keyframe's body
    cell_m: float
    half_cells: int
    settled: float  # a step below this is none


@dataclass(frozen=True, eq=False)
class Keyframe:
    """A patch of floor, coarse and fine, that later pictures are aligned with."""

    fine: Texture
    coarse: Texture


@dataclass(frozen=True)
class Alignment:
    """Where the body is in the keyframe, and how well that is known."""

    keyframe_from_body: Pose2
    covariance: Array  # (3, 3) [m, m, rad; body]
    correlation: float  # between the keyframe's values and those found, 1: identical


def make_keyframe(patch: FloorPatch, cells: Field, bare: NDArray[np.bool_]) -> Keyframe | None:
    """Return the keyframe of a sampled patch, (size, size); None where too little bare floor is seen to align with."""
    coarse_bare = cv2.erode(bare.astype(np.uint8), np.ones((COARSE_STEP, COARSE_STEP), np.uint8)).astype(np.bool_)
    if bare.sum() < POINTS // 4 or coarse_bare.sum() < POINTS // 4:
        return None
    coarse = _texture(patch, _smooth(cells), coarse_bare, COARSE_POINTS, COARSE_SETTLED)
    return Keyframe(_texture(patch, cells, bare, POINTS, SETTLED), coarse)


def align(keyframe: Keyframe, cells: Field, bare: NDArray[np.bool_], predicted: Pose2, prediction_covariance: Array) -> Alignment | None:
    """Return where the body is in the keyframe, given the newest patch and the wheels' prediction with its covariance, (3, 3) [body].

    None where the patches do not agree: too dark, too fast, or another floor.
    """
    coarse_cells = _smooth(cells)
    information = np.asarray(np.linalg.inv(prediction_covariance), dtype=np.float64)
    found = _refine(keyframe, cells, coarse_cells, bare, [predicted], predicted, information)
    if found is None:
        turned = [predicted @ Pose2(0.0, 0.0, float(turn)) for turn in SLIP_TURNS_RAD]
        found = _refine(keyframe, cells, coarse_cells, bare, turned, predicted, SLIP_INFORMATION)
    return found


def _refine(
    keyframe: Keyframe,
    cells: Field,
    coarse_cells: Field,
    bare: NDArray[np.bool_],
    starts: list[Pose2],
    predicted: Pose2,
    information: Array,
) -> Alignment | None:
    """Return the fine alignment from the best coarse one over all starts; None where none shows the same floor."""
    coarse = [_descend(keyframe.coarse, coarse_cells, bare, start, predicted, information) for start in starts]
    found = [alignment for alignment in coarse if alignment is not None]
    if not found:
        return None
    best = max(found, key=lambda alignment: alignment.correlation)
    fine = _descend(keyframe.fine, cells, bare, best.keyframe_from_body, predicted, information)
    return fine if fine is not None and fine.correlation > LEAST_CORRELATION else None


def _smooth(cells: Field) -> Field:
    return np.asarray(cv2.GaussianBlur(cells, (0, 0), 0.8 * COARSE_STEP), dtype=np.float32)


def _texture(patch: FloorPatch, cells: Field, bare: NDArray[np.bool_], count: int, settled: float) -> Texture:
    """Return the `count` points of bare floor where the texture is steepest."""
    scale = 1.0 / (8.0 * patch.cell_m)
    along_x = np.asarray(cv2.Sobel(cells, cv2.CV_32F, 0, 1, ksize=3, scale=scale), np.float32)
    along_y = np.asarray(cv2.Sobel(cells, cv2.CV_32F, 1, 0, ksize=3, scale=scale), np.float32)
    candidates = np.flatnonzero(bare)
    steepness = np.hypot(along_x, along_y).ravel()[candidates]
    chosen = candidates[np.argpartition(-steepness, count)[:count]] if candidates.size > count else candidates
    points = patch.points_m.reshape(-1, 2)[chosen]
    slope_x, slope_y = along_x.ravel()[chosen].astype(np.float64), along_y.ravel()[chosen].astype(np.float64)
    slopes = np.stack([slope_x, slope_y, points[:, 0] * slope_y - points[:, 1] * slope_x], axis=-1)
    return Texture(points, cells.ravel()[chosen].astype(np.float64), slopes, patch.cell_m, patch.half_cells, settled)


def _descend(
    texture: Texture, cells: Field, bare: NDArray[np.bool_], start: Pose2, predicted: Pose2, information: Array
) -> Alignment | None:
    """Iterate from `start` until the motion settles; None where too few points stay in view."""
    pose = start
    visible = bare.astype(np.float32)
    for _ in range(MAX_ROUNDS):
        found, weights = _look_up(texture, cells, visible, pose)
        if weights.sum() < 0.1 * weights.size:
            return None
        residuals = found - texture.values
        scale = robust_sigma(residuals[weights > 0.5]) + 1e-6
        weights = weights / (1.0 + (residuals / (2.0 * scale)) ** 2) ** 2  # Geman-McClure
        precision = 1.0 / (scale**2 * CORRELATED_POINTS)
        weighted = texture.slopes * (weights * precision)[:, None]
        to_body = pose.inverse().adjoint()
        hessian = weighted.T @ texture.slopes + to_body.T @ information @ to_body
        gradient = weighted.T @ residuals - to_body.T @ information @ predicted.between(pose).log()
        step = np.linalg.solve(hessian, gradient)
        pose = Pose2.exp(step) @ pose
        if np.abs(step).max() < texture.settled:
            break
    covariance = to_body @ np.linalg.inv(hessian) @ to_body.T + np.diag(FLOOR_SIGMA**2)
    return Alignment(pose, covariance, _correlation(found, texture.values, weights))


def _look_up(texture: Texture, cells: Field, visible: Field, pose: Pose2) -> tuple[Array, Array]:
    """Return the newest patch's values, (n,), where the keyframe's points now are, and 1 where that is bare floor, 0 elsewhere."""
    now = pose.inverse().apply(texture.points_m) / texture.cell_m + texture.half_cells
    column, row = now[None, :, 1].astype(np.float32), now[None, :, 0].astype(np.float32)
    values = cv2.remap(cells, column, row, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT, borderValue=0.0)
    seen = cv2.remap(visible, column, row, cv2.INTER_NEAREST, borderMode=cv2.BORDER_CONSTANT, borderValue=0.0)
    return values.ravel().astype(np.float64), seen.ravel().astype(np.float64)


def _correlation(a: Array, b: Array, weights: Array) -> float:
    """Return the correlation of two value vectors under weights that say only which points are seen."""
    seen = (weights > 0.0).astype(np.float64)
    a, b = a - np.average(a, weights=seen), b - np.average(b, weights=seen)
    return float((seen * a * b).sum() / np.sqrt((seen * a * a).sum() * (seen * b * b).sum() + 1e-12))
