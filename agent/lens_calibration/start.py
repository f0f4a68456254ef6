"""A first guess of lens and poses, from nothing but the corners: a scan over focal lengths of an equidistant lens."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from agent.lens_calibration.adjustment import Solution
from agent.lens_calibration.camera import BoardPose, Camera
from agent.lens_calibration.radial import KANNALA_BRANDT
from protocol.geometry import Array

FOCAL_SHARES = np.geomspace(0.08, 1.6, 30)  # of the picture's width
MOST_SCANNED = 12  # pictures: enough for a first guess
_WIDEST_RAD = np.radians(120.0)  # to the axis; a focal length that puts corners beyond it is too short


def first_guess(points_m: Array, corners: Sequence[Array], centre_px: Array, width_px: int) -> Solution:
    """Return the equidistant lens with its centre at (2,), and the poses, under which the corners (n, 2) a picture fit best."""
    some = corners[:: -(-len(corners) // MOST_SCANNED)]
    guesses = [_guess(points_m, some, centre_px, share * width_px) for share in FOCAL_SHARES]
    misses = [_miss_px(guess, points_m, some) for guess in guesses]
    return _guess(points_m, corners, centre_px, FOCAL_SHARES[int(np.argmin(misses))] * width_px)


def pose_of(camera: Camera, points_m: Array, corners: Array) -> BoardPose:
    """Return where a board with points (n, 3), z = 0, is by its corners (n, 2): a homography from the board to rays, at any angle.

    ray x (h1 X + h2 Y + h3) = 0 for all corners; h1, h2 are the first two columns of the rotation, up to a common scale (Zhang, "A flexible
    new technique for camera calibration", PAMI 2000, section 2, with rays in the place of pixels).
    """
    rays = camera.rays(corners)
    scale = float(np.abs(points_m).max())
    flat = np.column_stack([points_m[:, :2] / scale, np.ones(len(points_m))])
    x, y, z = rays.T[:, :, None] * flat.T[None].swapaxes(1, 2)
    none = np.zeros_like(x)
    equations = np.concatenate([np.hstack([none, -z, y]), np.hstack([z, none, -x]), np.hstack([-y, x, none])])
    columns = np.linalg.svd(equations, full_matrices=False)[2][-1].reshape(3, 3)
    if np.sum(rays * (flat @ columns.T)) < 0.0:
        columns = -columns
    size = np.sqrt(np.linalg.norm(columns[:, 0]) * np.linalg.norm(columns[:, 1])) + 1e-300
    first, second, origin = (columns / size).T
    left, _, right = np.linalg.svd(np.column_stack([first, second]), full_matrices=False)
    first, second = (left @ right).T
    return BoardPose(np.column_stack([first, second, np.cross(first, second)]), scale * origin)


def _guess(points_m: Array, corners: Sequence[Array], centre_px: Array, focal_px: float) -> Solution:
    camera = Camera(KANNALA_BRANDT, np.array([focal_px, focal_px, *centre_px, *KANNALA_BRANDT.start]))
    return Solution(camera, tuple(pose_of(camera, points_m, found) for found in corners))


def _miss_px(guess: Solution, points_m: Array, corners: Sequence[Array]) -> float:
    """Return by how much the corners of a middling picture are missed [px]."""
    reach = max(float(np.linalg.norm((found - guess.camera.values[2:4]) / guess.camera.values[:2], axis=1).max()) for found in corners)
    if reach > _WIDEST_RAD:
        return np.inf
    return float(np.median([np.sqrt((residual**2).sum(axis=1).mean()) for residual in guess.residuals(points_m, corners)]))
