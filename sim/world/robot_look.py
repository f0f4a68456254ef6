"""What robots look like: to each other, and what each sees of itself in the middle of its own picture."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np

from protocol.geometry import Array, Pose2
from sim.world.rounds import Round
from sim.world.scene import Placed, Rgb, RobotBody
from sim.world.silhouettes import Coverage, blend, coverage, outline
from sim.world.textures import Texture
from sim.world.view import Field, View

SHELL, BAND, BLOCK, DECK, RIM = (158, 150, 154), (38, 36, 38), (92, 90, 92), (62, 57, 57), (166, 164, 166)  # BGR
MARKS: tuple[tuple[float, float, float, float, Rgb], ...] = (  # on the deck: x, y, length and width in deck radii, colour
    (0.742, 0.0, 0.417, 0.156, (190, 190, 184)),
    (0.295, -0.685, 0.637, 0.269, (22, 24, 84)),
    (-0.514, 0.176, 0.478, 0.724, (24, 80, 38)),
)
TUBE_RADIUS_M, TUBE_OPACITY, TUBE = 0.02, 0.35, (150, 150, 148)
SHADOW_DEPTH, SHADOW_WIDTH_M, SHADOW_REACH_M = 0.2, 0.03, 0.08
TOP_PX, SIDE_TEXEL_M = 96, 0.002
RIM_DIRECTIONS = 96


def body_of(placed: Placed) -> Round:
    """Return a robot's body as others see it."""
    body = placed.body
    return Round(placed.arena_from_body, body.body_radius_m, body.body_height_m, _shell(body), _deck(body))


@dataclass(frozen=True, eq=False)
class OwnBody:
    """What hides the middle of a robot's own picture."""

    where: Coverage
    colours: Texture


def own_body(body: RobotBody, view: View) -> OwnBody | None:
    """Return the deck and its light rim as the robot's own camera sees them; None where it does not."""
    turn = np.linspace(0.0, 2.0 * np.pi, RIM_DIRECTIONS, endpoint=False)
    rim = np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    outer = view.pixels(np.insert(body.body_radius_m * rim, 2, body.body_height_m, axis=1))
    where = coverage(outer, view.canvas_px[::-1])
    if where is None:
        return None
    colours = np.full((*where.alpha.shape, 3), RIM, np.uint8)
    _fill(colours, where, view.pixels(np.insert(body.deck_radius_m * rim, 2, body.deck_height_m, axis=1)), DECK)
    for x, y, length, width, rgb in MARKS:
        corners = np.array([(x - length / 2, y - width / 2), (x + length / 2, y - width / 2), (x + length / 2, y + width / 2)])
        corners = body.deck_radius_m * np.vstack([corners, (x - length / 2, y + width / 2)])
        _fill(colours, where, view.pixels(np.insert(corners, 2, body.deck_height_m, axis=1)), rgb[::-1])
    return OwnBody(where, colours)


def _fill(colours: Texture, where: Coverage, pixels: Array, bgr: tuple[int, ...]) -> None:
    corners = np.rint((pixels - (where.cols.start, where.rows.start)) * 16.0).astype(np.int32)
    cv2.fillPoly(colours, [corners], bgr, cv2.LINE_AA, 4)


@lru_cache(maxsize=256)
def _shell(body: RobotBody) -> Texture:
    """Return the unrolled side: a light shell with the robot's name, blocks in a dark band above its foot, and a dark rim."""
    rows, cols = round(body.body_height_m / SIDE_TEXEL_M), round(2.0 * np.pi * body.body_radius_m / SIDE_TEXEL_M)
    side = np.full((rows, cols, 3), SHELL, np.uint8)
    _band(side, 0.02, 0.05, BAND)
    _band(side, 0.76, 0.91, BAND)
    blocks = (np.arange(cols) * 24 // cols) % 2 == 0
    low, high = round(0.79 * rows), round(0.88 * rows)
    side[low:high, blocks] = BLOCK
    for start in (0.05, 0.38, 0.72):
        cv2.putText(side, body.name.upper(), (round(start * cols), round(0.52 * rows)), cv2.FONT_HERSHEY_DUPLEX, 0.9, BAND, 2, cv2.LINE_AA)
    return side


def _band(side: Texture, start: float, end: float, bgr: tuple[int, int, int]) -> None:
    rows = side.shape[0]
    side[round(start * rows) : round(end * rows)] = bgr


@lru_cache(maxsize=256)
def _deck(body: RobotBody) -> Texture:
    """Return the top: the light rim, the dark deck, and what lies on it."""
    top = np.full((TOP_PX, TOP_PX, 3), RIM, np.uint8)
    centre, scale = (TOP_PX - 1) / 2.0, TOP_PX / 2.0 * body.deck_radius_m / body.body_radius_m
    cv2.circle(top, (round(centre), round(centre)), round(scale), DECK, cv2.FILLED, cv2.LINE_AA)
    for x, y, length, width, rgb in MARKS:
        first, last = (
            (round(centre - scale * (y + side * width / 2)), round(centre - scale * (x + side * length / 2))) for side in (1.0, -1.0)
        )
        cv2.rectangle(top, first, last, rgb[::-1], cv2.FILLED)
    return top


def dim_beside(canvas: Texture, places: Field, centre: Array, radius_m: float, view: View) -> None:
    """Lay the soft shadow of a body at a centre, (2,) [m; body], on the floor, whose places per pixel are (rows, cols, 2)."""
    reach_m = radius_m + SHADOW_REACH_M
    turn = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    rim = view.pixels(np.insert(centre + reach_m * np.stack([np.cos(turn), np.sin(turn)], axis=-1), 2, 0.0, axis=1))
    left, top = np.maximum(np.floor(rim.min(axis=0)).astype(int), 0).tolist()
    right, bottom = np.minimum(np.ceil(rim.max(axis=0)).astype(int) + 1, canvas.shape[1::-1]).tolist()
    if left >= right or top >= bottom:
        return
    part = canvas[top:bottom, left:right]
    aside = places[top:bottom, left:right] - centre.astype(np.float32)
    gap = np.clip(cv2.magnitude(aside[..., 0], aside[..., 1]) - np.float32(radius_m), 0.0, SHADOW_REACH_M)
    left_over = 1.0 / (1.0 + (SHADOW_REACH_M / SHADOW_WIDTH_M) ** 2)  # where the shadow ends
    dim = np.float32(1.0 + SHADOW_DEPTH * left_over) - np.float32(SHADOW_DEPTH) / (1.0 + (gap * np.float32(1.0 / SHADOW_WIDTH_M)) ** 2)
    part[:] = (part * dim[..., None]).astype(np.uint8)


def paint_tube(canvas: Texture, placed: Placed, body_from_arena: Pose2, view: View) -> None:
    """Lay the clear tube that carries a robot's camera over what is behind it."""
    centre = body_from_arena.apply(np.array(placed.arena_from_body[:2]))
    loop = outline(centre + TUBE_RADIUS_M * _TUBE, placed.body.camera_height_m - 0.02, view.eye_m)
    if loop is None:
        return
    loop[:, 2] = np.maximum(loop[:, 2], placed.body.body_height_m)
    where = coverage(view.pixels(loop), canvas.shape[:2])
    if where is not None:
        thin = Coverage(where.rows, where.cols, where.alpha * np.float32(TUBE_OPACITY))
        blend(canvas, thin, np.full((*where.alpha.shape, 3), TUBE, np.uint8))


_TUBE_TURN = np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False)
_TUBE = np.stack([np.cos(_TUBE_TURN), np.sin(_TUBE_TURN)], axis=-1)
