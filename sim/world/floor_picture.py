"""The arena's floor as one picture from above, with the shadows of all that does not move, and what a camera sees of it."""

from __future__ import annotations

import math
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from protocol.geometry import Array, Pose2
from sim.world.scene import Scene, Thing
from sim.world.textures import GRID_M, Texture, floor_texture
from sim.world.view import Field, View

TEXEL_M = 0.002
LEVELS = 4  # copies of the picture, each with texels twice as large as the one before
RINGS_M = (1.2, 0.5)  # floor beyond the first, beyond the second and within that is looked up in copies of its own
MARGIN_M = 0.60  # of floor beyond the arena's bounds
SHADOW_BLURS_M = ((0.012, 0.40), (0.06, 0.22))  # width and depth: the dark line where a thing stands, and the lamp's soft shadow
BACKGROUND = (128, 134, 150)  # BGR: what is beyond the floor, and above the horizon
NOWHERE_M = 1e4  # no floor reaches as far
SHADOW_SHIFT = (0.10, 0.06)  # of a thing's height, along x and y: the lamp hangs to one side
_SHIFT_BITS = 4


class FloorPicture:
    """One floor for all cameras of a scene."""

    def __init__(self, scene: Scene) -> None:
        low = np.array([scene.x_min_m, scene.y_min_m]) - MARGIN_M
        self._origin_m = np.floor(low / GRID_M) * GRID_M  # so that grid lines lie at multiples of their distance
        size_m = np.array([scene.x_max_m, scene.y_max_m]) + MARGIN_M - self._origin_m
        bare = floor_texture(scene.floor, float(size_m[0]), float(size_m[1]), TEXEL_M, np.random.default_rng([scene.seed, 1]))
        self._levels = [self._shaded(bare, scene.things)]
        for _ in range(1, LEVELS):
            self._levels.append(np.asarray(cv2.resize(self._levels[-1], None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)))

    def seen(self, places: Field, arena_from_body: Pose2, level: int) -> Texture:
        """Return the floor at places, (rows, cols, 2) x, y [m; body], as (rows, cols, 3), and the background beyond the picture."""
        texel_m = TEXEL_M * (1 << level)
        start = (np.array(arena_from_body[:2]) - self._origin_m) / texel_m - 0.5
        columns, rows = cv2.split(cv2.transform(places, np.column_stack([arena_from_body.rotation() / texel_m, start])))
        picture = self._levels[level]
        seen = cv2.remap(picture, columns, rows, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT, borderValue=BACKGROUND)
        return np.asarray(seen, np.uint8)

    def _shaded(self, bare: Texture, things: tuple[Thing, ...]) -> Texture:
        shade = np.ones(bare.shape[:2], np.float32)
        for width_m, depth in SHADOW_BLURS_M:
            cover = np.zeros(bare.shape[:2], np.float32)
            for thing in things:
                shift = np.array(SHADOW_SHIFT) * thing.height_m * (width_m / SHADOW_BLURS_M[-1][0])
                cv2.fillPoly(cover, [self._texels(thing.footprint_m + shift)], 1.0, cv2.LINE_AA, _SHIFT_BITS)
            shade *= 1.0 - depth * cv2.GaussianBlur(cover, (0, 0), width_m / TEXEL_M)
        return np.asarray(np.clip(np.rint(bare * shade[..., None]), 0, 255), np.uint8)

    def _texels(self, footprint_m: Array) -> NDArray[np.int32]:
        texels = (footprint_m - self._origin_m) / TEXEL_M - 0.5
        return np.asarray(np.rint(texels * (1 << _SHIFT_BITS)), np.int32)


class _Ring(NamedTuple):
    """The part of a canvas that sees the floor within some distance, and the copy of the floor's picture that fits it."""

    box: tuple[slice, slice]
    places: Field  # of the box's pixels, (rows, cols, 2) x, y [m; body]
    mask: NDArray[np.uint8]  # which of them lie within the distance
    level: int


class FloorSight:
    """Where the pixels of one view see the floor."""

    def __init__(self, view: View) -> None:
        self.places = _places(view)
        self._far_level = _level(RINGS_M[0], view)
        reach = np.hypot(*np.moveaxis(self.places - view.eye_m[:2].astype(np.float32), -1, 0))
        self._rings = [self._ring(reach, far, _level(near, view)) for near, far in zip((*RINGS_M[1:], 0.0), RINGS_M, strict=True)]

    def canvas(self, floor: FloorPicture, arena_from_body: Pose2) -> Texture:
        """Return the whole canvas, with nothing on the floor."""
        canvas = floor.seen(self.places, arena_from_body, self._far_level)
        for ring in self._rings:
            cv2.copyTo(floor.seen(ring.places, arena_from_body, ring.level), ring.mask, canvas[ring.box])
        return canvas

    def _ring(self, reach: Field, far_m: float, level: int) -> _Ring:
        within = (reach < far_m).astype(np.uint8)
        left, top, width, height = cv2.boundingRect(within)
        box = slice(top, top + height), slice(left, left + width)
        return _Ring(box, np.ascontiguousarray(self.places[box]), np.ascontiguousarray(within[box]), level)


def _places(view: View) -> Field:
    """Return the place on the floor that every pixel of a view's canvas sees, (rows, cols, 2) x, y [m; body]; `NOWHERE_M` where none."""
    x, y, z = view.rays
    length = np.float32(view.eye_m[2]) / np.maximum(-z, np.float32(1e-6))
    is_floor = (np.hypot(x, y) * length < NOWHERE_M)[..., None]
    places = view.eye_m[:2].astype(np.float32) + length[..., None] * np.stack([x, y], axis=-1)
    return np.where(is_floor, places, np.float32(NOWHERE_M)).astype(np.float32)


def _level(near_m: float, view: View) -> int:
    """Return the copy whose texels are as long as a pixel is on the floor, where a ring begins."""
    height_m = float(view.eye_m[2])
    pixel_m = (height_m**2 + near_m**2) / height_m / view.lens.px_per_rad
    return min(max(round(math.log2(pixel_m / TEXEL_M)), 0), LEVELS - 1)
