"""Where the floor can lie in the picture: a smaller picture with, for every pixel, the place on the floor it would show.

Floor removal works on this picture only. It is the camera's picture reduced by a whole factor, and cut to the part that can show floor.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from agent.vision.floor_projection import FloorProjection
from protocol.errors import GeometryError
from protocol.geometry import Array

Picture = NDArray[np.uint8]

WIDTH_PX = 640  # of the reduced picture; finer pixels cost time and tell nothing more about where the floor ends
BODY_MARGIN = 1.06  # the own body is masked this much wider than it should appear: its rim is bright and the rig never exact
REACH_IN_HEIGHTS = 4.6  # floor is judged out to this many camera heights; beyond (78 degrees off the axis) a pixel covers over 4 cm


RAYS = 16  # what goes all round the robot crosses each of them


@dataclass(frozen=True, eq=False)
class FloorView:
    """The reduced picture's geometry. `crop` is its part that can show floor, in reduced pixels."""

    scale: int  # camera pixels per reduced pixel
    crop: tuple[slice, slice]  # rows, columns
    origin_px: Array  # (2,) u, v of the crop's first pixel centre [camera px]
    nadir_px: Array  # (2,) u, v of the point under the camera [view px]
    valid: NDArray[np.bool_]  # (rows, cols): not own body, not beyond the reach, not outside the image circle
    range_m: NDArray[np.float32]  # (rows, cols) distance from the body's origin along the floor; inf where there is no floor
    bearing_rad: NDArray[np.float32]  # (rows, cols) from the body's x axis
    floor_m: Array  # (rows, cols, 2) the place on the floor [body]; NaN where there is none
    body_radius_m: float
    body_range_m: float  # floor nearer than this is hidden by the own body
    reach_m: float

    def reduce(self, picture: Picture) -> Picture:
        """Reduce a camera picture, shape (rows, cols, ...), to the view's own, averaging pixels."""
        rows, cols = self.crop
        full = picture[rows.start * self.scale : rows.stop * self.scale, cols.start * self.scale : cols.stop * self.scale]
        size = (cols.stop - cols.start, rows.stop - rows.start)
        return np.asarray(cv2.resize(full, size, interpolation=cv2.INTER_AREA), dtype=np.uint8)

    @cached_property
    def rays_px(self) -> list[tuple[NDArray[np.intp], NDArray[np.intp]]]:
        """The pixels, columns and rows, along some rays from the point under the camera to the view's border."""
        rows, cols = self.valid.shape
        steps = np.arange(np.hypot(rows, cols))
        rays = []
        for turn in np.arange(RAYS) * (2.0 * np.pi / RAYS):
            u, v = np.rint(self.nadir_px[:, None] + np.outer((np.cos(turn), np.sin(turn)), steps)).astype(np.intp)
            inside = (u >= 0) & (u < cols) & (v >= 0) & (v < rows)
            rays.append((u[inside], v[inside]))
        return rays

    def floor_of(self, pixels: NDArray[np.int32]) -> Array:
        """Return the places on the floor, (n, 2) [m; body], of whole pixels of the view, (n, 2) u, v; NaN where there is none."""
        return self.floor_m[pixels[:, 1], pixels[:, 0]]

    def camera_pixels(self, pixels: NDArray[Any]) -> Array:
        """Map pixels of the view, shape (n, 2) u, v, to camera pixels (n, 2)."""
        return np.asarray(pixels, dtype=np.float64) * self.scale + self.origin_px

    def view_pixels(self, pixels: Array) -> Array:
        """Map camera pixels, shape (n, 2) u, v, to pixels of the view (n, 2)."""
        return np.asarray((pixels - self.origin_px) / self.scale)


def make_floor_view(
    projection: FloorProjection,
    size_px: tuple[int, int],
    body_radius_m: float,
    body_height_m: float,
    crop: tuple[slice, slice] | None = None,
) -> FloorView:
    """Return the view of a camera with pictures of `size_px` (width, height), on a body with a rim of that radius and height.

    Without a `crop`, rows and columns, it is the part of the picture that can show floor.

    Raises GeometryError where the camera is not above the rim, or sees no floor.
    """
    height_m = projection.camera_height_m
    if height_m <= body_height_m:
        raise GeometryError(f"camera height {height_m} m must exceed body_height_m {body_height_m}")
    width, height = size_px
    scale = max(1, round(width / WIDTH_PX))
    part = crop or (slice(0, height // scale), slice(0, width // scale))
    rows, cols = np.mgrid[part]
    first = (scale - 1) / 2.0
    pixels = np.stack([cols * scale + first, rows * scale + first], axis=-1).reshape(-1, 2)
    floor = projection.floor_from_pixels(pixels)
    range_m = np.nan_to_num(np.hypot(floor[:, 0], floor[:, 1]), nan=np.inf).reshape(rows.shape)
    bearing = np.nan_to_num(np.arctan2(floor[:, 1], floor[:, 0])).reshape(rows.shape)
    body_range_m = BODY_MARGIN * body_radius_m * height_m / (height_m - body_height_m)
    reach_m = REACH_IN_HEIGHTS * height_m
    valid = (range_m > body_range_m) & (range_m < reach_m)
    if not valid.any():
        raise GeometryError("the calibration shows no floor in the picture: check intrinsics, T_BS and resolution")
    kept = (slice(None), slice(None))
    if crop is None:
        ys, xs = np.flatnonzero(valid.any(axis=1)), np.flatnonzero(valid.any(axis=0))
        crop = kept = (slice(int(ys[0]), int(ys[-1]) + 1), slice(int(xs[0]), int(xs[-1]) + 1))
    origin = np.array([crop[1].start * scale + first, crop[0].start * scale + first])
    places = floor.reshape(*rows.shape, 2)[kept].copy()
    fields = valid[kept].copy(), range_m[kept].astype(np.float32), bearing[kept].astype(np.float32), places
    under = projection.body_from_camera[:2, 3]
    nadir = (projection.pixels_from_floor(under[None])[0] - origin) / scale
    return FloorView(scale, crop, origin, nadir, *fields, body_radius_m=body_radius_m, body_range_m=body_range_m, reach_m=reach_m)
