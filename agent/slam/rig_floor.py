"""What two pictures of the same floor tell about the rig: under one motion, the floor agrees everywhere only where the rig is right.

The alignment of floor_motion.py with more unknowns: besides the motion, how far the body was tilted in each picture (its shaking), the
camera's parameters, and the wheels'. Only the rig's are kept; what depends on motion and shaking is eliminated (Schur complement).
"""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np

from agent.slam.floor_motion import CORRELATED_POINTS, Glance, Texture
from agent.slam.odometry import WheelNoise
from agent.slam.rig_parameters import CAMERA, PARAMETERS, TILT
from agent.slam.rig_sensitivity import FloorSensitivity
from agent.slam.wheel_path import WheelPath
from agent.vision.floor_patch import Field
from agent.vision.robust import robust_sigma
from protocol.geometry import Array, Pose2

SHAKING_RAD = 0.0035  # of a body that drives
EVERY = 6  # of the keyframe's points one in so many is used
MAX_ROUNDS, SETTLED_M = 3, 1e-4
SLIP_SCALE = 3.0  # sigmas of the wheels' own noise at which they lose half their weight
LEAST_SHARE = 0.1  # of the slopes, that has to be no noise
MOTION, SHAKING = slice(0, 3), slice(3, 7)
NUISANCES = 7


class Information(NamedTuple):
    """Normal equations of the rig's parameters, about those of the rig in use."""

    matrix: Array  # (PARAMETERS, PARAMETERS)
    vector: Array  # (PARAMETERS,)


class FloorPair:
    """A keyframe's texture and a newer picture of the same floor."""

    def __init__(self, texture: Texture, glance: Glance) -> None:
        self._points_m, self._values = texture.points_m[::EVERY], texture.values[::EVERY]
        self._slopes, self._texture = texture.slopes[::EVERY], texture
        self._glance, self._visible = glance, glance.bare.astype(np.float32)
        scale = 1.0 / (8.0 * texture.cell_m)
        self._slopes_now = tuple(cv2.Sobel(glance.cells, cv2.CV_32F, *order, ksize=3, scale=scale) for order in ((0, 1), (1, 0)))

    def information(self, start: Pose2, path: WheelPath, sensitivity: FloorSensitivity, sigma: Array) -> Information:
        """Return what the pair tells of the rig, given the motion as aligned so far, and how far off the rig may be, (PARAMETERS,)."""
        noise = WheelNoise()
        pose, unknowns = start, np.zeros(4 + PARAMETERS)  # shaking of both pictures, and the rig
        doubts = np.concatenate([np.full(4, SHAKING_RAD), sigma])
        for _ in range(MAX_ROUNDS):
            matrix, vector = self._floor_equations(pose, unknowns, sensitivity)
            wheel_matrix, wheel_vector = _wheel_equations(pose, unknowns[4:], path, noise)
            matrix, vector = matrix + wheel_matrix, vector + wheel_vector
            damped = matrix.copy()
            damped[3:, 3:] += np.diag(doubts**-2)
            step = np.linalg.solve(damped, vector - np.concatenate([np.zeros(3), unknowns / doubts**2]))
            pose, unknowns = Pose2.exp(step[MOTION]) @ pose, unknowns + step[3:]
            if np.abs(step[MOTION]).max() < SETTLED_M:
                break
        return _without_nuisances(matrix, vector + matrix[:, 3:] @ (unknowns - step[3:]))

    def _floor_equations(self, pose: Pose2, unknowns: Array, sensitivity: FloorSensitivity) -> tuple[Array, Array]:
        """Return the normal equations of motion, shaking and rig at where they are."""
        here = pose.inverse().apply(self._points_m)
        rotation = pose.rotation()
        then, now = sensitivity.at(self._points_m), rotation @ sensitivity.at(here)
        moves = np.concatenate([then[..., TILT], -now[..., TILT], then - now], axis=-1)  # (n, 2, 12) [keyframe body]
        places = here - self._glance.displacement_m(here) + (moves @ unknowns[: 4 + CAMERA.stop]) @ rotation
        cell = (places / self._texture.cell_m + self._texture.half_cells).astype(np.float32)
        rows, columns = cell[None, :, 0], cell[None, :, 1]
        values = cv2.remap(self._glance.cells, columns, rows, cv2.INTER_LINEAR)[0].astype(np.float64)
        seen = cv2.remap(self._visible, columns, rows, cv2.INTER_NEAREST)[0].astype(np.float64)
        residuals = values - self._values
        scale = robust_sigma(residuals[seen > 0.5]) + 1e-6
        weights = seen / (1.0 + (residuals / (2.0 * scale)) ** 2) ** 2 / (scale**2 * CORRELATED_POINTS / EVERY)
        terms = np.concatenate([-self._slopes, np.einsum("ni,nik->nk", self._slopes[:, :2], moves)], axis=-1)
        weighted = terms * weights[:, None]
        matrix, vector = np.zeros((3 + 4 + PARAMETERS,) * 2), np.zeros(3 + 4 + PARAMETERS)
        count = terms.shape[1]
        share = self._true_share(rotation, rows, columns, weights)
        matrix[:count, :count], vector[:count] = share**2 * (weighted.T @ terms), -share * (weighted.T @ residuals)
        return matrix, vector

    def _true_share(self, rotation: Array, rows: Field, columns: Field, weights: Array) -> float:
        """Return how much of the keyframe's slopes both pictures share: the rest is noise, which makes every step too short.

        Errors in variables: Fuller, "Measurement error models", 1987, section 1.2.
        """
        looked_up = [cv2.remap(slopes, columns, rows, cv2.INTER_LINEAR)[0] for slopes in self._slopes_now]
        now = np.stack(looked_up, axis=-1).astype(np.float64) @ rotation.T
        then = self._slopes[:, :2]
        return float(np.clip((weights[:, None] * now * then).sum() / (weights[:, None] * then * then).sum(), LEAST_SHARE, 1.0))


def _wheel_equations(pose: Pose2, rig: Array, path: WheelPath, noise: WheelNoise) -> tuple[Array, Array]:
    """Return the normal equations that say: the motion is what the wheels say, as far as they have not slipped."""
    by_wheels, sensitivity = path.motion(rig)
    off = by_wheels.between(pose).log()
    information = path.information(noise)
    information = information / (1.0 + float(off @ information @ off) / SLIP_SCALE**2)
    terms = np.zeros((3, 3 + 4 + PARAMETERS))
    terms[:, MOTION], terms[:, NUISANCES:] = pose.inverse().adjoint(), -sensitivity
    return terms.T @ information @ terms, -terms.T @ information @ off


def _without_nuisances(matrix: Array, vector: Array) -> Information:
    """Return the rig's part of normal equations: motion and shaking are eliminated."""
    inner = matrix[:NUISANCES, :NUISANCES].copy()
    inner[SHAKING, SHAKING] += np.eye(4) / SHAKING_RAD**2
    outer = matrix[NUISANCES:, :NUISANCES]
    reduced = outer @ np.linalg.inv(inner)
    return Information(matrix[NUISANCES:, NUISANCES:] - reduced @ outer.T, vector[NUISANCES:] - reduced @ vector[:NUISANCES])
