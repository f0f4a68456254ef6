"""One camera on one body: where points of the body's frame fall in its picture, and what each pixel looks at.

The canvas is the part of the picture that the lens fills, with a small border.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from protocol.geometry import Array
from sim.world.lens import Lens

Field = NDArray[np.float32]

BORDER_PX = 4
BARELY = np.float32(-1e-6)  # rays along a plane, or away from it, are taken as meeting it far away
_RIM_DIRECTIONS = 256


class Sight(NamedTuple):
    """What a part of a picture looks along."""

    rays: tuple[Field, Field, Field]  # x, y, z of unit rays, (rows, cols) each [body]
    eye_m: Array  # (3,) [body]
    px_per_rad: float

    def points(self, length_m: Field) -> tuple[Field, Field, Field]:
        """Return x, y, z where rays end that are so long, (rows, cols) each [m; body]."""
        x, y, z = (np.asarray(np.float32(start) + length_m * ray, np.float32) for start, ray in zip(self.eye_m, self.rays, strict=True))
        return x, y, z

    def length_to_level(self, height_m: float) -> Field:
        """Return how far rays go to a level plane below the eye, (rows, cols) [m]."""
        return np.asarray(np.float32(height_m - self.eye_m[2]) / np.minimum(self.rays[2], BARELY), np.float32)


@dataclass(frozen=True, eq=False)
class View:
    """A lens, how it is mounted, and the size of its picture."""

    lens: Lens
    body_from_camera: Array  # (4, 4)
    size_px: tuple[int, int]  # width, height

    def raised(self, height_m: float) -> View:
        """Return the view of the same camera so much higher above the floor, on which the body's frame stays."""
        body_from_camera = self.body_from_camera.copy()
        body_from_camera[2, 3] += height_m
        return View(self.lens, body_from_camera, self.size_px)

    @property
    def eye_m(self) -> Array:
        """Where the camera is, (3,) [m; body]."""
        return self.body_from_camera[:3, 3]

    @cached_property
    def origin_px(self) -> Array:
        """The picture's pixel at which the canvas begins, (2,) u, v; negative where the lens reaches beyond the picture."""
        return np.floor(self._field_px[0]) - BORDER_PX

    @cached_property
    def canvas_px(self) -> tuple[int, int]:
        """Width and height of the canvas."""
        width, height = (np.ceil(self._field_px[1]) + BORDER_PX + 1 - self.origin_px).astype(int).tolist()
        return width, height

    @cached_property
    def rays(self) -> tuple[Field, Field, Field]:
        """The x, y, z of the unit ray of every pixel of the canvas, (height, width) each [body]; beyond the field a ray of its border."""
        rays = np.where(self.in_field[..., None], self._rays_camera, self._rim[0]) @ self.body_from_camera[:3, :3].T
        x, y, z = (np.ascontiguousarray(rays[..., axis], np.float32) for axis in range(3))
        return x, y, z

    @cached_property
    def in_field(self) -> NDArray[np.bool_]:
        """Which pixels of the canvas the lens shows something in, (height, width)."""
        return np.asarray(np.isfinite(self._rays_camera[..., 2]))

    @cached_property
    def off_axis_rad(self) -> Field:
        """The angle of every pixel of the canvas to the optical axis, (height, width); NaN beyond the field."""
        return np.asarray(np.arccos(np.clip(self._rays_camera[..., 2], -1.0, 1.0)), np.float32)

    def sight(self, rows: slice, cols: slice) -> Sight:
        """Return what a part of the canvas looks along."""
        x, y, z = self.rays
        return Sight((x[rows, cols], y[rows, cols], z[rows, cols]), self.eye_m, self.lens.px_per_rad)

    def pixels(self, points_body: Array) -> Array:
        """Return where points (..., 3) [m; body] fall on the canvas, (..., 2) [px]; those out of the field on its border."""
        offsets = np.asarray(points_body) - self.eye_m
        return self.lens.pixels(offsets @ self.body_from_camera[:3, :3]) - self.origin_px

    def picture_of(self, canvas: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Return the picture, (height, width, 3), that a canvas fills; black where the lens shows nothing."""
        width, height = self.size_px
        u, v = self.origin_px.astype(int).tolist()
        rows, cols = canvas.shape[:2]
        picture = np.zeros((height, width, 3), np.uint8)
        left, top, right, bottom = max(u, 0), max(v, 0), min(u + cols, width), min(v + rows, height)
        picture[top:bottom, left:right] = canvas[top - v : bottom - v, left - u : right - u]
        return picture

    @cached_property
    def _rays_camera(self) -> Field:
        width, height = self.canvas_px
        pixels = np.stack(np.meshgrid(np.arange(width), np.arange(height)), axis=-1) + self.origin_px
        return self.lens.rays(pixels).astype(np.float32)

    @cached_property
    def _rim(self) -> Array:
        """Rays along the field's border, (n, 3) [camera]."""
        turn = np.linspace(0.0, 2.0 * np.pi, _RIM_DIRECTIONS)
        angle = self.lens.widest_rad
        return np.stack([np.sin(angle) * np.cos(turn), np.sin(angle) * np.sin(turn), np.full_like(turn, np.cos(angle))], axis=-1)

    @cached_property
    def _field_px(self) -> tuple[Array, Array]:
        """The least and the greatest u, v of the field's border, or of the picture, whichever is narrower."""
        pixels = self.lens.pixels(self._rim)
        return np.maximum(pixels.min(axis=0), 0.0), np.minimum(pixels.max(axis=0), np.array(self.size_px) - 1.0)
