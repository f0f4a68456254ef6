"""What a calibration is worth: by how much directions may be wrong, and how much of the field the board was seen in."""

from __future__ import annotations

import numpy as np

from agent.lens_calibration.camera import FRAME, BoardPose, Camera
from agent.lens_calibration.fit import LensFit
from protocol.geometry import Array

OUTER_SHARE = 0.6  # of the way from the centre to the border: beyond it a corner counts for its direction
SECTORS = ("right", "lower right", "lower edge", "lower left", "left", "upper left", "upper edge", "upper right")
_RINGS, _TURNS = 25, 16
_AT_ORIGIN = BoardPose(np.eye(3), np.zeros(3))


def direction_errors_rad(fit: LensFit) -> Array:
    """Return the standard deviation of a direction at angles to the axis from nearly zero to as far as corners were seen, (n,).

    The corners' own noise, carried through the adjustment, and by how much the two families of lenses disagree.
    """
    angles = np.linspace(0.02, fit.seen_to_rad, _RINGS)
    turns = np.linspace(0.0, 2.0 * np.pi, _TURNS, endpoint=False)
    along = np.stack([np.cos(turns), np.sin(turns)], axis=-1)
    sine, cosine = np.sin(angles)[:, None, None], np.cos(angles)[:, None, None]
    rays = np.concatenate([sine * along[None], np.broadcast_to(cosine, (_RINGS, _TURNS, 1))], axis=-1).reshape(-1, 3)
    drawn = fit.camera.draw(rays, _AT_ORIGIN)
    covariance_px = drawn.by_lens @ fit.best.covariance @ np.swapaxes(drawn.by_lens, 1, 2)
    disagreement_px = drawn.pixels - fit.other.solution.camera.project(rays)
    covariance_px += disagreement_px[:, :, None] * disagreement_px[:, None, :]
    largest_px = np.sqrt(np.linalg.eigvalsh(covariance_px)[:, -1])
    px_per_rad = np.repeat(_px_per_rad(fit.camera, angles), _TURNS)
    return np.asarray((largest_px / px_per_rad).reshape(_RINGS, _TURNS).max(axis=1))


def empty_sectors(fit: LensFit, radius_px: float) -> list[str]:
    """Return the sides of the picture where no corner lies in the outer part of what can be seen there; the field's radius is given."""
    centre = fit.camera.values[2:FRAME]
    offset = np.concatenate(fit.corners) - centre
    distance = np.hypot(offset[:, 0], offset[:, 1])
    room = np.where(offset > 0.0, np.array(fit.size_px) - 1.0 - centre, centre)
    to_frame = distance * (room / np.maximum(np.abs(offset), 1e-9)).min(axis=1)
    outer = offset[distance > OUTER_SHARE * np.minimum(to_frame, radius_px)]
    sector = np.rint(np.arctan2(outer[:, 1], outer[:, 0]) / (0.25 * np.pi)).astype(int) % len(SECTORS)
    return [name for i, name in enumerate(SECTORS) if i not in sector]


def _px_per_rad(camera: Camera, angles: Array) -> Array:
    """Return how many pixels an angle of one radian takes at angles to the axis, in the direction where it takes fewest."""
    radius, slope, _ = camera.family.radius(angles, camera.values[FRAME:])
    return np.asarray(camera.values[:2].min() * np.minimum(np.maximum(slope, 1e-3), radius / np.sin(angles)))
