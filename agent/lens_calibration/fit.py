"""From corners to a lens: first guess, adjustment, pictures that do not agree left out, and the family of lenses that fits better."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from agent.lens_calibration.adjustment import Solution, adjust, lens_covariance
from agent.lens_calibration.board import Board
from agent.lens_calibration.camera import FRAME, BoardPose, Camera
from agent.lens_calibration.radial import KANNALA_BRANDT, UNIFIED, RadialFamily
from agent.lens_calibration.start import first_guess, pose_of
from protocol.geometry import Array

LEAST_PICTURES = 4  # below them, lens and poses cannot be told apart
DISAGREEING, LEAST_DISAGREEING_PX = 3.0, 0.5  # times the usual error of a picture, from which it is left out
_CURVE_NODES = 400


@dataclass(frozen=True, eq=False)
class FamilyFit:
    """What one family of lenses makes of the corners."""

    solution: Solution
    residuals: tuple[Array, ...]  # (n, 2) [px] a used picture
    covariance: Array  # of the lens's values

    @property
    def rms_px(self) -> float:
        """Root mean square of the distances by which corners are missed."""
        return rms_px(np.concatenate(self.residuals))


@dataclass(frozen=True, eq=False)
class LensFit:
    """A lens as found, and how."""

    board: Board
    size_px: tuple[int, int]
    corners: tuple[Array, ...]  # of the used pictures
    used: tuple[int, ...]  # their places among those that were given
    picture_rms_px: tuple[float, ...]  # of all pictures that were given
    best: FamilyFit
    other: FamilyFit

    @property
    def camera(self) -> Camera:
        """The lens."""
        return self.best.solution.camera

    @property
    def rays(self) -> Array:
        """The directions in which corners were seen, (n, 3) [camera]."""
        poses = self.best.solution.poses
        points = np.concatenate([pose.apply(self.board.points_m) for pose in poses])
        return np.asarray(points / np.linalg.norm(points, axis=1, keepdims=True))

    @property
    def seen_to_rad(self) -> float:
        """The largest angle to the axis at which a corner was seen."""
        return float(np.arccos(np.clip(self.rays[:, 2], -1.0, 1.0)).max())


def fit_lens(board: Board, corners: Sequence[Array], size_px: tuple[int, int]) -> LensFit:
    """Return the lens under which corners, (n, 2) [px] for each of at least LEAST_PICTURES pictures, lie on a flat board."""
    points_m = board.points_m
    middle_px = 0.5 * (np.array(size_px, np.float64) - 1.0)
    solution = _adjusted(first_guess(points_m, corners, middle_px, size_px[0]), points_m, corners)
    solution = _adjusted(_with_better_poses(solution, points_m, corners), points_m, corners)
    rms = np.array([rms_px(residual) for residual in solution.residuals(points_m, corners)])
    used = _agreeing(rms)
    kept = tuple(corners[i] for i in used)
    start = Solution(solution.camera, tuple(solution.poses[i] for i in used))
    fits = [_family_fit(family, start, points_m, kept) for family in (KANNALA_BRANDT, UNIFIED)]
    best, other = sorted(fits, key=_information_criterion)
    rms[list(used)] = [rms_px(residual) for residual in best.residuals]
    return LensFit(board, size_px, kept, used, tuple(rms.tolist()), best, other)


def as_kannala_brandt(camera: Camera, to_rad: float) -> tuple[Camera, float]:
    """Return the Kannala-Brandt lens nearest to a camera out to an angle, and by how much it draws at most differently [px]."""
    if camera.family is KANNALA_BRANDT:
        return camera, 0.0
    angle = np.linspace(0.0, to_rad, _CURVE_NODES)
    radius = camera.family.radius(angle, camera.values[FRAME:]).radius
    powers = np.stack([angle ** (2 * order + 1) for order in range(5)], axis=-1)
    terms = np.linalg.lstsq(powers, radius, rcond=None)[0]
    values = np.concatenate([camera.values[:2] * terms[0], camera.values[2:FRAME], terms[1:] / terms[0]])
    return Camera(KANNALA_BRANDT, values), float(camera.values[:2].max() * np.abs(powers @ terms - radius).max())


def rms_px(residuals: Array) -> float:
    """Return the root mean square length of residuals (n, 2) [px]."""
    return float(np.sqrt((residuals**2).sum(axis=1).mean()))


def _adjusted(solution: Solution, points_m: Array, corners: Sequence[Array]) -> Solution:
    """Return the solution adjusted, first with the shape of the lens held: it would otherwise make up for a wrong centre."""
    everything = np.ones(solution.camera.values.size, bool)
    frame_only = np.arange(everything.size) < FRAME
    return adjust(adjust(solution, points_m, corners, frame_only), points_m, corners, everything)


def _family_fit(family: RadialFamily, start: Solution, points_m: Array, corners: Sequence[Array]) -> FamilyFit:
    if start.camera.family is not family:
        values = np.concatenate([start.camera.values[:FRAME], family.start])
        start = Solution(Camera(family, values), start.poses)
    solution = _adjusted(start, points_m, corners)
    return FamilyFit(solution, tuple(solution.residuals(points_m, corners)), lens_covariance(solution, points_m, corners))


def _with_better_poses(solution: Solution, points_m: Array, corners: Sequence[Array]) -> Solution:
    """Return the solution with each picture's pose found anew where that fits better: a first guess may have been a wrong one."""
    poses = tuple(
        min((old, pose_of(solution.camera, points_m, found)), key=lambda pose: _pose_miss_px(solution.camera, pose, points_m, found))
        for old, found in zip(solution.poses, corners, strict=True)
    )
    return Solution(solution.camera, poses)


def _pose_miss_px(camera: Camera, pose: BoardPose, points_m: Array, found: Array) -> float:
    return rms_px(found - camera.project(pose.apply(points_m)))


def _agreeing(rms: Array) -> tuple[int, ...]:
    """Return the places of pictures that agree with most others; all of them where too few would be left."""
    limit = max(DISAGREEING * float(np.median(rms)), LEAST_DISAGREEING_PX)
    used = tuple(int(i) for i in np.flatnonzero(rms <= limit))
    return used if len(used) >= LEAST_PICTURES else tuple(range(len(rms)))


def _information_criterion(fit: FamilyFit) -> float:
    """Return n ln(mean square) + k ln n, by which of lenses that fit equally well the simpler is taken.

    Source: Schwarz, "Estimating the dimension of a model", 1978.
    """
    count = 2 * sum(len(residual) for residual in fit.residuals)
    return count * float(np.log(fit.rms_px**2)) + fit.solution.camera.values.size * float(np.log(count))
