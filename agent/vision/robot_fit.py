"""Other robots in the picture: an upright cylinder of known size, fitted to its silhouette with sub-pixel accuracy.

The silhouette of a cylinder seen from above its rim is the near arc of its base, two upright lines, and the far arc of its rim. Edges are
looked for along its normals, and the cylinder is moved until they agree (Harris and Stennett, "RAPID, a video rate object tracker", BMVC
1990), with robust weights, so that a half hidden robot or a strong pattern beside the silhouette does not pull.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from agent.vision.floor_projection import FloorProjection
from agent.vision.floor_view import Picture
from agent.vision.robust import median, robust_sigma
from agent.vision.small_systems import solved
from protocol.geometry import Array

BASE_POINTS, SIDE_POINTS, RIM_POINTS = 24, 14, 16
ARC_SHARE = 0.92  # of the visible base arc; its ends meet the sides at a corner
RIM_SHARE = 0.85
SIDE_FROM, SIDE_TO = 0.07, 0.97  # of the body's height
_RIM = RIM_SHARE * np.linspace(-1.0, 1.0, RIM_POINTS)
# Where the points lie, counted from the direction of the camera: turns, and shares of half the angle that the camera sees of the base.
_TURNS = np.concatenate([np.zeros(BASE_POINTS + 2 * SIDE_POINTS), np.pi + np.pi * _RIM])
_SHARES = np.concatenate([ARC_SHARE * np.linspace(-1.0, 1.0, BASE_POINTS), np.repeat([-1.0, 1.0], SIDE_POINTS), -_RIM])
_HEIGHTS = np.concatenate([np.zeros(BASE_POINTS), np.tile(np.linspace(SIDE_FROM, SIDE_TO, SIDE_POINTS), 2), np.ones(RIM_POINTS)])
STEP_M = 1e-3  # of the centre, and outward: for differences
_AHEAD, _ASIDE = np.array([STEP_M, 0.0, 0.0]), np.array([0.0, STEP_M, 0.0])
SEARCH_HALF_PX, SEARCH_STEP_PX = 3.0, 0.75  # along the normals
PREFERENCE_PX = 2.0  # an edge this far from the expected place counts at 60 % of its strength
LEAST_CONTRAST = 5.0  # grey levels per pixel of an edge
LEAST_BEND = -1e-6  # of the contrast about its peak
CLIPPED_CONTRAST = 12.0  # beyond this an edge counts no more: a printed pattern must not outweigh a silhouette
MAX_ROUNDS, ROBUST_ROUNDS = 6, 3
_DAMPING = 1e-6 * np.eye(2)  # keeps a step defined where all edges run one way
SETTLED_M = 5e-4  # the step after a smaller one would be far smaller still
AGREEING_PX = 1.5  # an edge within this of the fitted silhouette supports it
LEAST_SUPPORT = 0.6  # share of base, and of either side or the other with the rim, that must be supported
EDGE_SIGMA_PX = 0.5  # of one edge, beyond what its scatter shows: the contact shadow, and paint that is no perfect cylinder
SEARCH_RANGES_M = np.array([-0.007, 0.0, 0.007])  # a range profile tells a base to about this
SEARCH_TURNS = np.linspace(-0.2, 0.2, 7)  # of half the cylinder's angular width; ... and its direction to this


@dataclass(frozen=True)
class RobotFit:
    """Where a robot's base centre is, and how much of its silhouette was found."""

    centre_m: Array  # (2,) [body]
    covariance: Array  # (2, 2) [m^2; body]
    support: float
    misfit_px: float  # median distance of the upright sides from their edges: tells a base from a ring painted above it


class Silhouette(NamedTuple):
    """Points on the outline of an upright cylinder as the camera sees it: base arc, left side, right side, rim arc."""

    points: Array  # (..., n, 3) [m; body]
    normals: Array  # (..., n, 3) outward, horizontal


def silhouettes(centres: Array, eye_m: Array, radius_m: float, height_m: float) -> Silhouette:
    """Return the outlines of cylinders that stand at `centres`, (..., 2), for a camera above `eye_m`, (2,) [m; body]."""
    away = centres - eye_m
    towards = np.arctan2(-away[..., 1], -away[..., 0])[..., None]
    distance = np.hypot(away[..., 0], away[..., 1])[..., None]
    half = np.arccos(np.minimum(radius_m / distance, 1.0))  # tangents from the camera touch the base here
    angles = towards + _TURNS + half * _SHARES
    normals = np.stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)], axis=-1)
    points = radius_m * normals
    points[..., :2] += centres[..., None, :]
    points[..., 2] = height_m * _HEIGHTS
    return Silhouette(points, normals)


class RobotFitter:
    """Fits cylinders of one size in pictures of one camera."""

    def __init__(self, projection: FloorProjection, radius_m: float, height_m: float) -> None:
        self._projection = projection
        self._radius_m = radius_m
        self._height_m = height_m
        self._eye_m = projection.body_from_camera[:2, 3]
        steps = np.arange(-SEARCH_HALF_PX, SEARCH_HALF_PX + 1e-9, SEARCH_STEP_PX)
        self._offsets_px = steps[1:-1]
        self._preference = np.exp(-0.5 * (self._offsets_px / PREFERENCE_PX) ** 2)
        self._profile_px = steps

    def search(self, grey: Picture, near_m: float, bearing_rad: float) -> Array | None:
        """Return the most convincing base centre, (2,) [m; body], of a robot whose base begins about `near_m` from the camera.

        None where no silhouette stands out.
        """
        width = float(np.arcsin(min(1.0, self._radius_m / (near_m + self._radius_m))))
        distance = (near_m + self._radius_m + SEARCH_RANGES_M)[:, None]
        bearing = bearing_rad + SEARCH_TURNS[None, :] * width
        offsets = distance[..., None] * np.stack([np.cos(bearing), np.sin(bearing)], axis=-1)
        centres = (self._eye_m + offsets).reshape(-1, 2)
        scores = self._scores(grey, centres)
        best = int(np.argmax(scores))
        return centres[best] if scores[best] > 0.5 * LEAST_CONTRAST else None

    def fit(self, grey: Picture, centre_m: Array) -> RobotFit | None:
        """Return the fit nearest to a start, (2,) [m; body], that is right to about two pixels; None where there is no such robot."""
        centre = np.asarray(centre_m, dtype=np.float64)
        for _ in range(MAX_ROUNDS):
            if np.hypot(*(centre - self._eye_m)) < 1.2 * self._radius_m:
                return None
            edges_px, found, slopes = self._measure(grey, centre)
            if found.sum() < LEAST_SUPPORT * found.size / 2.0:
                return None
            move, weights = _robust_move(slopes[found], edges_px[found])
            centre = centre + move
            if np.abs(move).max() < SETTLED_M:
                break
        agreeing = np.zeros(found.size)
        agreeing[found] = np.abs(edges_px[found] - slopes[found] @ move) < AGREEING_PX
        support = _support(agreeing)
        if support < LEAST_SUPPORT:
            return None
        residuals = edges_px - slopes @ move
        scatter = float(np.average(residuals[found] ** 2, weights=weights + 1e-9))
        sides = np.abs(residuals[BASE_POINTS:-RIM_POINTS])[found[BASE_POINTS:-RIM_POINTS]]
        spread = np.linalg.inv(slopes[found].T @ (slopes[found] * weights[:, None]) + 1e-9 * np.eye(2))
        # Errors of neighbouring edges go together (shadow, calibration): a quarter of the edges are taken as independent.
        return RobotFit(centre, np.asarray(4.0 * spread * (scatter + EDGE_SIGMA_PX**2)), support, float(median(sides)))

    def _measure(self, grey: Picture, centre: Array) -> tuple[Array, NDArray[np.bool_], Array]:
        """Return for every silhouette point where its edge is, along the picture's normal, (n,) [px], and whether one was found, (n,).

        The third result, (n, 2) [px/m], is how the point moves along that normal with the centre.
        """
        points, normals = silhouettes(centre, self._eye_m, self._radius_m, self._height_m)
        moved = np.concatenate([points, points + STEP_M * normals, points + _AHEAD, points + _ASIDE])
        here, *elsewhere = self._projection.pixels_from_points(moved).reshape(4, -1, 2)
        outward, ahead, aside = (pixels - here for pixels in elsewhere)
        normal = outward / np.maximum(np.hypot(outward[:, 0], outward[:, 1]), 1e-9)[:, None]
        slopes = (np.stack([ahead, aside], axis=1) * normal[:, None]).sum(axis=-1) / STEP_M
        edges, contrast = self._edges(grey, here, normal)
        found = (contrast > LEAST_CONTRAST) & np.isfinite(here[:, 0])
        return edges, found, slopes

    def _edges(self, grey: Picture, here: Array, normal: Array) -> tuple[Array, Array]:
        """Return the place of the strongest edge near each point along its normal (n,) [px], and its contrast (n,) [grey levels per px]."""
        values = _sampled(grey, here[:, None] + self._profile_px[None, :, None] * normal[:, None])
        steepness = np.abs(values[:, 2:] - values[:, :-2]) / (2.0 * SEARCH_STEP_PX)
        strongest = np.argmax(steepness * self._preference, axis=1)
        rows = np.arange(len(here))
        inner = np.clip(strongest, 1, steepness.shape[1] - 2)
        before, at, after = steepness[rows, inner - 1], steepness[rows, inner], steepness[rows, inner + 1]
        bend = before - 2.0 * at + after
        is_peak = (strongest == inner) & (bend < LEAST_BEND)
        shift = np.where(is_peak, np.clip(0.5 * (before - after) / np.minimum(bend, LEAST_BEND), -0.5, 0.5), 0.0)
        return self._offsets_px[strongest] + shift * SEARCH_STEP_PX, steepness[rows, strongest]

    def _scores(self, grey: Picture, centres: Array) -> Array:
        """Return the mean clipped contrast across the silhouettes of robots at `centres`, (n, 2) [m; body]."""
        shapes = silhouettes(centres, self._eye_m, self._radius_m, self._height_m)
        points, normals = shapes.points[:, ::2], shapes.normals[:, ::2]
        width = 0.004
        ends = np.stack([points + width * normals, points - width * normals])
        pixels = self._projection.pixels_from_points(ends.reshape(-1, 3)).reshape(2 * len(centres), -1, 2)
        outer, inner = np.split(_sampled(grey, pixels), 2)
        apart = np.subtract(*np.split(pixels, 2))
        length = np.fmax(np.hypot(apart[..., 0], apart[..., 1]), 1.0)
        return np.asarray(np.minimum(np.abs(outer - inner) / length, CLIPPED_CONTRAST).mean(axis=1))


def _sampled(grey: Picture, pixels: Array) -> Array:
    """Return the grey levels, (n, m), at pixels (n, m, 2), interpolated; black where the lens does not see them."""
    inside = np.where(np.isfinite(pixels), pixels, -1e3).astype(np.float32)
    return cv2.remap(grey, inside[..., 0], inside[..., 1], cv2.INTER_LINEAR).astype(np.float64)


def _robust_move(slopes: Array, edges_px: Array) -> tuple[Array, Array]:
    """Return the move of the centre, (2,) [m], that brings the silhouette onto its edges, and the weight of each edge (n,)."""
    move: Array = np.zeros(2)
    weights: Array = np.ones(len(edges_px))
    for _ in range(ROBUST_ROUNDS):
        residuals = edges_px - slopes @ move
        scale = max(0.3, robust_sigma(residuals))
        weights = np.asarray((1.0 + (residuals / (1.5 * scale)) ** 2) ** -2, dtype=np.float64)
        weighted = slopes * weights[:, None]
        move = solved(weighted.T @ slopes + _DAMPING, weighted.T @ edges_px)
    return move, weights


def _support(agreeing: Array) -> float:
    """Return how much of the silhouette is found: the least of base, better side, and the other side together with the rim."""
    base = agreeing[:BASE_POINTS].mean()
    left, right = agreeing[BASE_POINTS : BASE_POINTS + SIDE_POINTS].mean(), agreeing[BASE_POINTS + SIDE_POINTS : -RIM_POINTS].mean()
    rim = agreeing[-RIM_POINTS:].mean()
    return float(min(base, max(left, right), 0.5 * (min(left, right) + rim) + 0.15))
