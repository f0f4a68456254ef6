"""The robot's own motion from the floor's texture: direct alignment of the newest picture with a keyframe.

Points of the keyframe where the texture has structure are looked for in the newest patch, all under one rigid motion, by Gauss-Newton on
their differences (inverse compositional: Baker and Matthews, "Lucas-Kanade 20 years on", IJCV 2004, section 3.2) with robust weights,
started from and held by what the wheels say. No feature is matched, so a regular grid does no harm as long as the wheels are right to
half a mesh.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from agent.vision.floor_patch import Field, FloorPatch
from agent.vision.robust import robust_sigma
from agent.vision.shutter import RollingShutter
from agent.vision.small_systems import solved
from protocol.geometry import Array, Pose2

POINTS = 3000
COARSE_POINTS = 1000
COARSE_STEP = 3  # cells per coarse cell; its basin of attraction is that much wider
BLOCK_CELLS, CROWDED = 12, 2.5  # along each side of a part of the patch; of no part more than so many times its even share of points
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


@dataclass(frozen=True, eq=False)
class Glance:
    """What one picture shows of the floor, and how the body moved while its rows were taken."""

    cells: Field  # (size, size)
    bare: NDArray[np.bool_]  # (size, size) where bare floor is seen
    shutter: RollingShutter
    speed_m_s: float = 0.0
    turn_rad_s: float = 0.0

    def displacement_m(self, points_m: Array) -> Array:
        """Return how far floor points, (n, 2) [m; body] as they are seen, are from where they are at the stamp."""
        return self.shutter.displacement_m(points_m, self.speed_m_s, self.turn_rad_s)


def make_keyframe(patch: FloorPatch, glance: Glance) -> Keyframe | None:
    """Return the keyframe of a picture; None where too little bare floor is seen to align with."""
    cells, bare = glance.cells, glance.bare
    coarse_bare = cv2.erode(bare.astype(np.uint8), np.ones((COARSE_STEP, COARSE_STEP), np.uint8)).astype(np.bool_)
    if bare.sum() < POINTS // 4 or coarse_bare.sum() < POINTS // 4:
        return None
    coarse = _texture(patch, _smooth(cells), coarse_bare, COARSE_POINTS, COARSE_SETTLED)
    fine = _texture(patch, cells, bare, POINTS, SETTLED)
    return Keyframe(*(replace(texture, points_m=texture.points_m + glance.displacement_m(texture.points_m)) for texture in (fine, coarse)))


def align(keyframe: Keyframe, glance: Glance, predicted: Pose2, prediction_covariance: Array) -> Alignment | None:
    """Return where the body is in the keyframe, given the newest picture and the wheels' prediction with its covariance, (3, 3) [body].

    None where the patches do not agree: too dark, too fast, or another floor.
    """
    coarse = smoothed(glance)
    information = np.asarray(np.linalg.inv(prediction_covariance), dtype=np.float64)
    found = _refine(keyframe, glance, coarse, [predicted], predicted, information)
    if found is None:
        turned = [predicted @ Pose2(0.0, 0.0, float(turn)) for turn in SLIP_TURNS_RAD]
        found = _refine(keyframe, glance, coarse, turned, predicted, SLIP_INFORMATION)
    return found


def _refine(
    keyframe: Keyframe,
    glance: Glance,
    coarse_glance: Glance,
    starts: list[Pose2],
    predicted: Pose2,
    information: Array,
) -> Alignment | None:
    """Return the fine alignment from the best coarse one over all starts; None where none shows the same floor."""
    coarse = [descend(keyframe.coarse, coarse_glance, start, predicted, information) for start in starts]
    found = [alignment for alignment in coarse if alignment is not None]
    if not found:
        return None
    best = max(found, key=lambda alignment: alignment.correlation)
    fine = descend(keyframe.fine, glance, best.keyframe_from_body, predicted, information)
    return fine if fine is not None and fine.correlation > LEAST_CORRELATION else None


def smoothed(glance: Glance) -> Glance:
    """Return a glance as the coarse texture of a keyframe is to be compared with."""
    return replace(glance, cells=_smooth(glance.cells))


def _smooth(cells: Field) -> Field:
    return np.asarray(cv2.GaussianBlur(cells, (0, 0), 0.8 * COARSE_STEP), dtype=np.float32)


def _texture(patch: FloorPatch, cells: Field, bare: NDArray[np.bool_], count: int, settled: float) -> Texture:
    """Return about `count` points of bare floor where the texture is steepest, not too many from any part of the patch.

    The steepest of all would be borders of light and shadow, which need not lie still.
    """
    scale = 1.0 / (8.0 * patch.cell_m)
    along_x = np.asarray(cv2.Sobel(cells, cv2.CV_32F, 0, 1, ksize=3, scale=scale), np.float32)
    along_y = np.asarray(cv2.Sobel(cells, cv2.CV_32F, 1, 0, ksize=3, scale=scale), np.float32)
    chosen = _steepest_of_blocks(np.where(bare, np.hypot(along_x, along_y), np.float32(-1.0)), count)
    points = patch.points_m.reshape(-1, 2)[chosen]
    slope_x, slope_y = along_x.ravel()[chosen].astype(np.float64), along_y.ravel()[chosen].astype(np.float64)
    slopes = np.stack([slope_x, slope_y, points[:, 0] * slope_y - points[:, 1] * slope_x], axis=-1)
    return Texture(points, cells.ravel()[chosen].astype(np.float64), slopes, patch.cell_m, patch.half_cells, settled)


def _steepest_of_blocks(steepness: Field, count: int) -> NDArray[np.intp]:
    """Return the flat places of the `count` steepest cells, of no block more than CROWDED even shares; cells below zero do not count."""
    blocks = steepness.shape[0] // BLOCK_CELLS
    side = blocks * BLOCK_CELLS
    by_block = steepness[:side, :side].reshape(blocks, BLOCK_CELLS, blocks, BLOCK_CELLS).swapaxes(1, 2).reshape(-1, BLOCK_CELLS**2)
    usable = max(int((by_block >= 0.0).any(axis=1).sum()), 1)
    most = min(max(1, round(CROWDED * count / usable)), BLOCK_CELLS**2 - 1)
    best = np.argpartition(-by_block, most, axis=1)[:, :most]
    steepest = np.take_along_axis(by_block, best, axis=1)
    block = np.arange(len(by_block))[:, None]
    rows, columns = block // blocks * BLOCK_CELLS + best // BLOCK_CELLS, block % blocks * BLOCK_CELLS + best % BLOCK_CELLS
    places = (rows * steepness.shape[1] + columns)[steepest >= 0.0]
    left = steepest[steepest >= 0.0]
    return np.asarray(places[np.argpartition(-left, count)[:count]] if len(left) > count else places, np.intp)


def descend(texture: Texture, glance: Glance, start: Pose2, predicted: Pose2, information: Array) -> Alignment | None:
    """Iterate from `start` until the motion settles, held to `predicted` by `information`, (3, 3) [body].

    None where too few points stay in view.
    """
    pose = start
    visible = glance.bare.astype(np.float32)
    for _ in range(MAX_ROUNDS):
        found, weights = _look_up(texture, glance, visible, pose)
        if weights.sum() < 0.1 * weights.size:
            return None
        residuals = found - texture.values
        scale = robust_sigma(residuals[weights > 0.5]) + 1e-6
        weights = weights / (1.0 + (residuals / (2.0 * scale)) ** 2) ** 2  # Geman-McClure
        precision = 1.0 / (scale**2 * CORRELATED_POINTS)
        weighted = texture.slopes * (weights * precision)[:, None]
        to_body = pose.inverse().adjoint()
        hold = to_body.T @ information
        hessian = weighted.T @ texture.slopes + hold @ to_body
        gradient = weighted.T @ residuals - hold @ predicted.between(pose).log()
        step = solved(hessian, gradient)
        pose = Pose2.exp(step) @ pose
        if np.abs(step).max() < texture.settled:
            break
    covariance = to_body @ np.linalg.inv(hessian) @ to_body.T + np.diag(FLOOR_SIGMA**2)
    return Alignment(pose, covariance, _correlation(found, texture.values, weights))


def _look_up(texture: Texture, glance: Glance, visible: Field, pose: Pose2) -> tuple[Array, Array]:
    """Return the newest patch's values, (n,), where the keyframe's points now are, and 1 where that is bare floor, 0 elsewhere."""
    here = pose.inverse().apply(texture.points_m)
    now = (here - glance.displacement_m(here)) / texture.cell_m + texture.half_cells
    column, row = now[None, :, 1].astype(np.float32), now[None, :, 0].astype(np.float32)
    values = cv2.remap(glance.cells, column, row, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT, borderValue=0.0)
    seen = cv2.remap(visible, column, row, cv2.INTER_NEAREST, borderMode=cv2.BORDER_CONSTANT, borderValue=0.0)
    return values.ravel().astype(np.float64), seen.ravel().astype(np.float64)


def _correlation(a: Array, b: Array, weights: Array) -> float:
    """Return the correlation of two value vectors under weights that say only which points are seen."""
    seen = weights > 0.0
    a, b = a[seen], b[seen]
    a, b = a - a.mean(), b - b.mean()
    return float(a @ b / np.sqrt((a @ a) * (b @ b) + 1e-12))
