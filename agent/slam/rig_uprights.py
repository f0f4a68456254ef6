"""What upright edges tell about the rig: where the vertical is in the picture, and with the own rim, tilt and lens centre apart.

The floor and one rim hardly tell a tilted camera from a lens centre that is off. Upright edges do, since both move them by other amounts,
and the more so the farther out they are.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from agent.rig import Calibration
from agent.slam.rig_floor import SHAKING_RAD, Information
from agent.slam.rig_parameters import CAMERA, PARAMETERS, TILT, changed_projection
from agent.slam.rig_sensitivity import differences
from agent.vision.robust import robust_sigma
from agent.vision.upright_edges import UprightEdges, bearing_rays
from protocol.geometry import Array

LEAN_RAD = 0.0026  # by which what is built upright is not
TURNS = 64  # bearings at which the sensitivity is worked out
LEAST_EDGES = 3
GUESSED_PICTURES = 3.0  # that the guess of how much the body shakes counts for
ROUNDS = 6


class Upright(NamedTuple):
    """What one picture's edges tell."""

    information: Information
    shaking_rad2: float  # mean square of the body's tilt in this picture, about x and about y


class Shaking:
    """How far the body is tilted from picture to picture, as edges show it: one that rolls smoothly is believed more.

    A variance by expectation maximisation (Dempster, Laird and Rubin 1977), which begins with the guess that holds for the floor.
    """

    def __init__(self) -> None:
        self._pictures, self._sum_rad2 = GUESSED_PICTURES, GUESSED_PICTURES * SHAKING_RAD**2

    @property
    def sigma_rad(self) -> float:
        """One sigma, about x and about y."""
        return float(np.sqrt(self._sum_rad2 / self._pictures))

    def add(self, shaking_rad2: float) -> None:
        """Take one more picture's mean square."""
        self._pictures, self._sum_rad2 = self._pictures + 1.0, self._sum_rad2 + shaking_rad2


class UprightSensitivity:
    """By how much the slant of upright edges changes with every parameter of the camera."""

    def __init__(self, calibration: Calibration, angles_rad: Array) -> None:
        """Take the angles from straight down, (bands,), at which edges are followed."""
        turns = np.linspace(0.0, 2.0 * np.pi, TURNS, endpoint=False)
        rays = bearing_rays(angles_rad, turns)
        projection = changed_projection(calibration, np.zeros(CAMERA.stop))
        pixels = projection.lens.project(rays @ projection.body_from_camera[:3, :3]).reshape(-1, 2)
        ahead, aside = (np.stack([np.cos(turns + turn), np.sin(turns + turn), 0.0 * turns], axis=-1) for turn in (0.0, 0.5 * np.pi))

        def bearings(change: Array) -> Array:
            """Return by how much bearings grow, (bands, TURNS) [rad]."""
            seen = changed_projection(calibration, change).rays_from_pixels(pixels).reshape(rays.shape)
            return np.asarray(np.arctan2((seen * aside).sum(axis=-1), (seen * ahead).sum(axis=-1)), np.float64)

        self._bearings = np.nan_to_num(differences(calibration, bearings))  # (bands, TURNS, 8)
        self._cotangents = 1.0 / np.tan(angles_rad)

    def at(self, edges: UprightEdges) -> Array:
        """Return d slant / d parameter of n edges, shape (n, 8)."""
        turns = np.rint(edges.bearing_rad * (TURNS / (2.0 * np.pi))).astype(int) % TURNS
        bands = np.arange(len(self._cotangents))
        crossed = (bands >= edges.first[:, None]) & (bands <= edges.last[:, None])
        mean = (crossed * self._cotangents).sum(axis=1) / crossed.sum(axis=1)
        off = crossed * (self._cotangents - mean[:, None])
        shares = off / (off**2).sum(axis=1)[:, None]  # of each band in the slope of a straight line
        return np.asarray(np.einsum("nb,bnk->nk", shares, self._bearings[:, turns]), np.float64)


def upright_information(
    edges: UprightEdges, sensitivity: UprightSensitivity, expected: Array, covariance: Array, shaking_rad: float
) -> Upright | None:
    """Return what one picture's edges tell of the rig; None where there are too few.

    `expected` (8,) is how far the camera is believed to be off the rig in use, with `covariance` (8, 8). Edges that contradict that
    and each other are taken not to be upright. The body's tilt in this picture, with `shaking_rad` for one sigma, is eliminated.
    """
    if len(edges.slant_rad) < LEAST_EDGES:
        return None
    camera = sensitivity.at(edges)
    terms = np.concatenate([camera[:, TILT], camera], axis=1)  # shaking first
    missing = -edges.slant_rad  # with the true rig, an upright edge has no slant
    still = np.eye(2) / shaking_rad**2
    prior = np.zeros((2 + CAMERA.stop,) * 2)
    prior[:2, :2], prior[2:, 2:] = still, np.linalg.inv(covariance)
    believed = np.concatenate([np.zeros(2), expected])
    sigma = np.hypot(edges.sigma_rad, LEAN_RAD)
    found = believed
    for _ in range(ROUNDS):
        weights = _weights((terms @ found - missing) / sigma) / sigma**2
        weighted = terms * weights[:, None]
        matrix, vector = weighted.T @ terms, weighted.T @ missing
        found = np.linalg.solve(matrix + prior, vector + prior @ believed)
    unshaken = np.linalg.inv(matrix[:2, :2] + still)
    shaking_rad2 = 0.5 * float(found[:2] @ found[:2] + np.trace(unshaken))
    return Upright(_without_shaking(matrix, vector, unshaken), shaking_rad2)


def _weights(misfits: Array) -> Array:
    """Return what edges count, (n,), by how far off they are in sigmas: Geman-McClure, at a scale that is at least theirs."""
    scale = max(robust_sigma(misfits), 1.0)
    return np.asarray(1.0 / (1.0 + (misfits / (2.0 * scale)) ** 2) ** 2 / scale**2, np.float64)


def _without_shaking(matrix: Array, vector: Array, unshaken: Array) -> Information:
    """Return the rig's part of normal equations; shaking, of covariance `unshaken` (2, 2) for a known rig, is eliminated."""
    reduced = matrix[2:, :2] @ unshaken
    told = Information(np.zeros((PARAMETERS, PARAMETERS)), np.zeros(PARAMETERS))
    told.matrix[CAMERA, CAMERA] = matrix[2:, 2:] - reduced @ matrix[:2, 2:]
    told.vector[CAMERA] = vector[2:] - reduced @ vector[:2]
    return told
