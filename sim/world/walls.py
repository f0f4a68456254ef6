"""The walls of a room: one colour each, with a dark skirting at their foot, since they fill much of a picture."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from protocol.geometry import Pose2
from sim.world.light import side_brightness
from sim.world.scene import Rgb, Thing
from sim.world.silhouettes import both_ways, facing, fill, following
from sim.world.view import View

SKIRTING_M = 0.04
SKIRTING_RGB: Rgb = (62, 60, 60)


def paint_wall(canvas: NDArray[np.uint8], wall: Thing, body_from_arena: Pose2, view: View) -> None:
    """Paint a wall as a view sees it: its top behind, then the sides that face the eye, then their foot."""
    near, behind = both_ways(body_from_arena.apply(wall.footprint_m), view.eye_m)
    if len(near) < 2:
        return
    heights_m = (0.0, min(SKIRTING_M, wall.height_m), wall.height_m)
    ways = [*(np.insert(near, 2, height_m, axis=1) for height_m in heights_m), np.insert(behind, 2, wall.height_m, axis=1)]
    foot, skirting, edge, back = np.split(view.pixels(np.concatenate(ways)), len(near) * np.arange(1, 4))
    if wall.height_m < view.eye_m[2]:
        fill(canvas, np.concatenate([edge, back]), _bgr(wall.rgb, 1.0))
    fill(canvas, np.concatenate([foot, edge[::-1]]), _bgr(wall.rgb, _brightness(wall, body_from_arena, view)))
    fill(canvas, np.concatenate([foot, skirting[::-1]]), SKIRTING_RGB[::-1])


def _brightness(wall: Thing, body_from_arena: Pose2, view: View) -> float:
    """Return how bright the longest side is that faces the eye."""
    corners = wall.footprint_m
    way = following(corners) - corners
    length = np.hypot(way[:, 0], way[:, 1])
    seen = facing(body_from_arena.apply(corners), view.eye_m[:2])
    return side_brightness(way[int(np.argmax(np.where(seen, length, 0.0)))])


def _bgr(rgb: Rgb, share: float) -> tuple[int, ...]:
    return tuple(round(share * channel) for channel in rgb[::-1])
