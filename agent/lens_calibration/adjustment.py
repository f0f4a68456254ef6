"""Bundle adjustment of one camera over many pictures of a board: Levenberg-Marquardt on the normal equations, poses eliminated.

Source: Triggs et al., "Bundle adjustment: a modern synthesis", 2000, section 6.1 (Schur complement); damping by Marquardt's scaling;
Huber's weights (Zhang, "Parameter estimation techniques", 1997, section 9.4).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from agent.lens_calibration.camera import BoardPose, Camera
from agent.vision.robust import robust_sigma
from protocol.geometry import Array

Mask = NDArray[np.bool_]

MAX_ROUNDS = 60
SETTLED = 1e-7  # of the sum of squares, by which a last round may still make it smaller
FIRST_DAMPING, LEAST_DAMPING, MOST_DAMPING = 1e-3, 1e-12, 1e8
HUBER_SIGMAS = 2.5  # beyond them a corner pulls no harder
LEAST_SIGMA_PX = 0.02


@dataclass(frozen=True, eq=False)
class Solution:
    """A camera and where the board was in each picture."""

    camera: Camera
    poses: tuple[BoardPose, ...]

    def residuals(self, points_m: Array, corners: Sequence[Array]) -> list[Array]:
        """Return by how much each picture's corners (n, 2) [px] lie off where the solution draws the board's points (n, 3)."""
        return [found - self.camera.project(pose.apply(points_m)) for found, pose in zip(corners, self.poses, strict=True)]


class _Normals(NamedTuple):
    """Normal equations in blocks: lens, and poses of the pictures."""

    cost: float
    lens: Array  # (m, m)
    lens_right: Array  # (m,)
    poses: Array  # (pictures, 6, 6)
    poses_right: Array  # (pictures, 6)
    mixed: Array  # (pictures, m, 6)


def adjust(start: Solution, points_m: Array, corners: Sequence[Array], free: Mask) -> Solution:
    """Return the solution near `start` under which the corners, (n, 2) [px] a picture, fit best; of the lens, values `free` may move."""
    solution, damping = start, FIRST_DAMPING
    for _ in range(MAX_ROUNDS):
        sigma_px = spread_px(solution.residuals(points_m, corners))
        normals = _normal_equations(solution, points_m, corners, free, sigma_px)
        better, cost, damping = _step(solution, normals, points_m, corners, free, sigma_px, damping)
        gain = normals.cost - cost
        solution = better
        if gain <= SETTLED * normals.cost:
            break
    return solution


def lens_covariance(solution: Solution, points_m: Array, corners: Sequence[Array]) -> Array:
    """Return the covariance (m, m) of the lens's values, from the corners' own spread; the poses are eliminated."""
    sigma_px = spread_px(solution.residuals(points_m, corners))
    free = np.ones(solution.camera.values.size, bool)
    normals = _normal_equations(solution, points_m, corners, free, sigma_px)
    reduced, _ = _without_poses(normals, normals.poses)
    return np.asarray(sigma_px**2 * np.linalg.pinv(reduced, hermitian=True))


def spread_px(residuals: Sequence[Array]) -> float:
    """Return the standard deviation of residuals along one axis, in spite of outliers [px]."""
    return max(robust_sigma(np.concatenate([each.ravel() for each in residuals])), LEAST_SIGMA_PX)


def _step(
    solution: Solution, normals: _Normals, points_m: Array, corners: Sequence[Array], free: Mask, sigma_px: float, damping: float
) -> tuple[Solution, float, float]:
    """Return the next solution, its cost and the damping that led to it; the solution itself where no step makes it better."""
    while damping < MOST_DAMPING:
        tried = _moved(solution, normals, free, damping)
        cost = sum(_costs(residual, sigma_px).sum() for residual in tried.residuals(points_m, corners))
        if cost < normals.cost:
            return tried, float(cost), max(0.2 * damping, LEAST_DAMPING)
        damping *= 6.0
    return solution, normals.cost, damping


def _moved(solution: Solution, normals: _Normals, free: Mask, damping: float) -> Solution:
    """Return the solution after one damped step."""
    diagonal = np.einsum("pii->pi", normals.poses)
    damped = normals.poses + damping * np.einsum("pi,ij->pij", diagonal, np.eye(6))
    reduced, right = _without_poses(normals, damped)
    reduced = reduced + damping * np.diag(np.diag(normals.lens))
    lens_step = np.linalg.lstsq(reduced, right, rcond=1e-14)[0]
    pose_steps = np.linalg.solve(damped, (normals.poses_right - lens_step @ normals.mixed)[..., None])[..., 0]
    values = solution.camera.values.copy()
    values[free] += lens_step
    poses = tuple(pose.moved(step) for pose, step in zip(solution.poses, pose_steps, strict=True))
    return Solution(replace(solution.camera, values=values), poses)


def _without_poses(normals: _Normals, poses: Array) -> tuple[Array, Array]:
    """Return the lens's normal equations after elimination of the poses, whose own block is given."""
    gain = np.linalg.solve(poses, np.swapaxes(normals.mixed, 1, 2))  # (pictures, 6, m)
    matrix = normals.lens - np.einsum("pmi,pin->mn", normals.mixed, gain)
    return matrix, normals.lens_right - np.einsum("pim,pi->m", gain, normals.poses_right)


def _normal_equations(solution: Solution, points_m: Array, corners: Sequence[Array], free: Mask, sigma_px: float) -> _Normals:
    count, pictures = int(free.sum()), len(corners)
    lens, lens_right = np.zeros((count, count)), np.zeros(count)
    poses, poses_right = np.zeros((pictures, 6, 6)), np.zeros((pictures, 6))
    mixed = np.zeros((pictures, count, 6))
    cost = 0.0
    for i, (found, pose) in enumerate(zip(corners, solution.poses, strict=True)):
        drawn = solution.camera.draw(points_m, pose)
        residual = found - drawn.pixels
        cost += float(_costs(residual, sigma_px).sum())
        weights = np.repeat(_weights(residual, sigma_px), 2)[:, None]
        by_lens = drawn.by_lens[:, :, free].reshape(-1, count)
        by_pose = drawn.by_pose.reshape(-1, 6)
        flat = residual.reshape(-1)
        lens += by_lens.T @ (weights * by_lens)
        lens_right += (weights * by_lens).T @ flat
        poses[i], poses_right[i] = by_pose.T @ (weights * by_pose), (weights * by_pose).T @ flat
        mixed[i] = by_lens.T @ (weights * by_pose)
    return _Normals(cost, lens, lens_right, poses, poses_right, mixed)


def _weights(residual: Array, sigma_px: float) -> Array:
    """Return what each corner counts, (n,): 1 near where it is expected, less beyond."""
    limit = HUBER_SIGMAS * sigma_px
    return np.asarray(limit / np.maximum(np.hypot(residual[:, 0], residual[:, 1]), limit))


def _costs(residual: Array, sigma_px: float) -> Array:
    """Return Huber's cost of each corner, (n,) [px^2]: square near where it is expected, linear beyond."""
    limit = HUBER_SIGMAS * sigma_px
    off = np.hypot(residual[:, 0], residual[:, 1])
    return np.where(off <= limit, off**2, 2.0 * limit * off - limit**2)
