"""Forward mapping of points: from a pixel to the place on the floor that it shows, and back, for a camera at any tilt."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from agent.vision.lens import Lens
from protocol.errors import GeometryError
from protocol.geometry import Array

_HORIZON_MARGIN = 1e-4  # sine of the least depression below the horizon: a thirtieth of a pixel, 5 km away for a camera half a metre high
_ROTATION_TOLERANCE = 1e-3  # calibrations are printed with few digits


@dataclass(frozen=True, eq=False)
class FloorProjection:
    """The floor z = 0 of the body frame as one camera sees it.

    `body_from_camera` is the rigid motion T_BS, shape (4, 4) [m]. Raises GeometryError where it is none, or the camera not above the floor.
    """

    lens: Lens
    body_from_camera: Array

    def __post_init__(self) -> None:
        """Refuse a matrix that is not the pose of a camera above the floor."""
        matrix = self.body_from_camera
        if matrix.shape != (4, 4) or not np.isfinite(matrix).all():
            raise GeometryError(f"camera pose T_BS: needs 4 x 4 finite numbers, not {matrix.tolist()}")
        rotation = matrix[:3, :3]
        if np.abs(rotation @ rotation.T - np.eye(3)).max() > _ROTATION_TOLERANCE or np.linalg.det(rotation) < 0.0:
            raise GeometryError(f"camera pose T_BS: its upper left 3 x 3 block is not a rotation: {rotation.tolist()}")
        if matrix[2, 3] <= 0.0:
            raise GeometryError(f"camera pose T_BS: the camera must be above the floor, not at z = {matrix[2, 3]} m")

    @property
    def camera_height_m(self) -> float:
        """Height of the camera above the floor."""
        return float(self.body_from_camera[2, 3])

    @cached_property
    def _camera_from_body(self) -> Array:
        return np.asarray(np.linalg.inv(self.body_from_camera), dtype=np.float64)

    def rays_from_pixels(self, pixels: ArrayLike) -> Array:
        """Map pixels, shape (n, 2) [px], to unit rays (n, 3) [body]; NaN outside the image circle."""
        return np.asarray(self.lens.unproject(pixels) @ self.body_from_camera[:3, :3].T)

    def floor_from_pixels(self, pixels: ArrayLike) -> Array:
        """Map pixels, shape (n, 2) [px], to floor points (n, 2) [m; body]; NaN for a ray at or above the horizon."""
        rays = self.rays_from_pixels(pixels)
        return np.asarray(self.body_from_camera[:2, 3] + self._floor_distance(rays)[:, None] * rays[:, :2])

    def points_from_pixels(self, pixels: ArrayLike, reach_m: float) -> Array:
        """Map pixels, shape (n, 2) [px], to points (n, 3) [m; body] where their rays end: on the floor or, in the air, after `reach_m`."""
        rays = self.rays_from_pixels(pixels)
        distance = np.fmin(self._floor_distance(rays), reach_m)
        return np.asarray(self.body_from_camera[:3, 3] + distance[:, None] * rays)

    def pixels_from_points(self, points: ArrayLike) -> Array:
        """Map points, shape (n, 3) [m; body], to pixels (n, 2) [px]; NaN where the lens does not see them."""
        camera_from_body = self._camera_from_body
        return self.lens.project(np.asarray(points, dtype=np.float64) @ camera_from_body[:3, :3].T + camera_from_body[:3, 3])

    def pixels_from_floor(self, points: ArrayLike) -> Array:
        """Map floor points, shape (n, 2) [m; body], to pixels (n, 2) [px]; NaN where the lens does not see them."""
        flat = np.asarray(points, dtype=np.float64)
        return self.pixels_from_points(np.concatenate([flat, np.zeros_like(flat[:, :1])], axis=1))

    def _floor_distance(self, rays: Array) -> Array:
        """Length, shape (n,) [m], at which unit rays (n, 3) [body] meet the floor; NaN where they do not."""
        depression = -rays[:, 2]
        return np.asarray(self.camera_height_m / np.where(depression > _HORIZON_MARGIN, depression, np.nan))
