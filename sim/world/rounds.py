"""Upright cylinders, whose sides are pictures, unrolled."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from protocol.geometry import Array, Pose2, wrap_angle
from sim.world.light import DARK_SIDE, LIT_SIDE, light_in
from sim.world.textures import Texture
from sim.world.view import Field, Sight

SIDES = 48


@dataclass(frozen=True, eq=False)
class Round:
    """An upright cylinder. Its side's picture begins ahead and runs counter-clockwise; its top's has ahead at its upper border."""

    arena_from_solid: Pose2
    radius_m: float
    height_m: float
    side: Texture
    top: Texture

    def footprint(self, body_from_arena: Pose2) -> Array:
        """Return its footprint, a polygon of the circle's area; see `Solid`."""
        return np.asarray(body_from_arena.apply(self.arena_from_solid[:2]) + self.radius_m * _CIRCLE)

    def colours(self, sight: Sight, body_from_arena: Pose2) -> Texture:
        """Return its colours; see `Solid`."""
        body_from_solid = body_from_arena @ self.arena_from_solid
        x, y, z = self._on_side(sight, body_from_solid)
        ahead = np.arctan2(y, x) - np.float32(wrap_angle(body_from_solid.theta_rad))
        ahead += np.float32(2.0 * np.pi) * (ahead < 0.0)
        columns = ahead * np.float32(self.side.shape[1] / (2.0 * np.pi)) - np.float32(0.5)
        rows = (np.float32(self.height_m) - z) * np.float32(self.side.shape[0] / self.height_m) - np.float32(0.5)
        unlit = cv2.remap(self.side, columns, rows, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        light = light_in(body_from_arena) * ((LIT_SIDE - DARK_SIDE) / self.radius_m)
        lit = np.float32(DARK_SIDE) + np.maximum(np.float32(light[0]) * x + np.float32(light[1]) * y, np.float32(0.0))
        seen: Texture = (unlit * lit[..., None]).astype(np.uint8)
        if self.height_m < sight.eye_m[2]:
            self._lay_top(seen, sight, body_from_solid)
        return seen

    def _on_side(self, sight: Sight, body_from_solid: Pose2) -> tuple[Field, Field, Field]:
        """Return where rays meet the side first, from the axis's foot [m; body axes]; those that miss it, where they pass nearest."""
        ex, ey = np.float32(sight.eye_m[0] - body_from_solid.x_m), np.float32(sight.eye_m[1] - body_from_solid.y_m)
        rx, ry, _ = sight.rays
        flat = np.maximum(rx * rx + ry * ry, np.float32(1e-9))
        half = rx * ex + ry * ey
        root = np.sqrt(np.maximum(half * half - flat * np.float32(ex * ex + ey * ey - self.radius_m**2), np.float32(0.0)))
        length = (-half - root) / flat
        start = (ex, ey, np.float32(sight.eye_m[2]))
        x, y, z = (np.asarray(here + length * ray, np.float32) for here, ray in zip(start, sight.rays, strict=True))
        return x, y, z

    def _lay_top(self, seen: Texture, sight: Sight, body_from_solid: Pose2) -> None:
        """Lay the top's picture where rays meet the top."""
        x, y, _ = sight.points(sight.length_to_level(self.height_m))
        x -= np.float32(body_from_solid.x_m)
        y -= np.float32(body_from_solid.y_m)
        over = (x * x + y * y <= np.float32(self.radius_m**2)).view(np.uint8)
        left, top, width, height = cv2.boundingRect(over)
        if width == 0:
            return
        box = slice(top, top + height), slice(left, left + width)
        size = self.top.shape[0]
        scale = size / (2.0 * self.radius_m)
        cos, sin = np.float32(scale * np.cos(body_from_solid.theta_rad)), np.float32(scale * np.sin(body_from_solid.theta_rad))
        middle = np.float32(0.5 * (size - 1))
        rows, columns = middle - cos * x[box] - sin * y[box], middle + sin * x[box] - cos * y[box]
        laid = cv2.remap(self.top, columns, rows, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        cv2.copyTo(laid, over[box], seen[box])


def _circle(sides: int) -> Array:
    """Return a regular polygon, (n, 2), of the area of the unit circle."""
    turn = np.arange(sides) * (2.0 * np.pi / sides)
    radius = np.sqrt(2.0 * np.pi / (sides * np.sin(2.0 * np.pi / sides)))
    return np.asarray(radius * np.column_stack([np.cos(turn), np.sin(turn)]))


_CIRCLE = _circle(SIDES)
