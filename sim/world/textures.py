"""What surfaces look like: floors and the materials of things, as pictures made from a seed."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import cv2
import numpy as np
from numpy.typing import NDArray

from sim.world.scene import FloorKind, Material, Rgb

Texture = NDArray[np.uint8]  # (rows, cols, 3) BGR
Field = NDArray[np.float32]
Rng = np.random.Generator

GRID_M, LINE_M = 0.05, 0.004  # the grid floor's cells and lines
PLANK_M, PLANK_LENGTH_M, GROOVE_M = 0.09, 0.9, 0.002
STRIPE_M = 0.04
SPECKLE_M = 0.012


def floor_texture(kind: FloorKind, width_m: float, height_m: float, texel_m: float, rng: Rng) -> Texture:
    """Return a floor of this size; column 0 and row 0 lie at its least x and y."""
    shape = (round(height_m / texel_m), round(width_m / texel_m))
    return _levels(_FLOORS[kind](shape, texel_m, rng))


def surface_texture(material: Material, rgb: Rgb, width_m: float, height_m: float, texel_m: float, rng: Rng) -> Texture:
    """Return a face of this size, of a material in a colour."""
    shape = (max(2, round(height_m / texel_m)), max(2, round(width_m / texel_m)))
    colour = np.array(rgb[::-1], np.float32)
    return _levels(colour * _MATERIALS[material](shape, texel_m, rng)[..., None])


def _levels(values: Field) -> Texture:
    return np.clip(np.rint(values), 0, 255).astype(np.uint8)


def noise(shape: tuple[int, int], texels: float, rng: Rng) -> Field:
    """Return smooth noise with features of so many texels, about zero, one standard deviation one."""
    rows, cols = (max(2, round(size / texels) + 3) for size in shape)
    coarse = rng.standard_normal((rows, cols)).astype(np.float32)
    fine = cv2.resize(coarse, (round(cols * texels), round(rows * texels)), interpolation=cv2.INTER_CUBIC)[: shape[0], : shape[1]]
    return np.asarray(fine / max(float(fine.std()), 1e-6), np.float32)


def _grey(level: float, *layers: Field) -> Field:
    """Return a grey floor: the level and what is added to it, in all three channels."""
    return np.repeat((level + np.sum(layers, axis=0))[..., None], 3, axis=-1).astype(np.float32)


def _paint(shape: tuple[int, int], texel_m: float, rng: Rng) -> Field:
    """Matte paint: faint clouds and grain, and scratches."""
    floor = _grey(150.0, 3.0 * noise(shape, 0.25 / texel_m, rng), 1.5 * noise(shape, 0.03 / texel_m, rng), 1.2 * noise(shape, 3.0, rng))
    for _ in range(round(8.0 * shape[0] * shape[1] * texel_m**2)):
        _scratch(floor, texel_m, rng)
    return floor


def _scratch(floor: Field, texel_m: float, rng: Rng) -> None:
    """Draw a shallow arc, a little darker or lighter than the floor."""
    start = rng.uniform((0, 0), (floor.shape[1], floor.shape[0]))
    heading, bend = rng.uniform(0.0, 2.0 * np.pi), rng.uniform(-4.0, 4.0)
    along = np.linspace(0.0, rng.uniform(0.05, 0.25), 20)
    turn = heading + bend * along
    step = np.gradient(along) / texel_m
    line = start + np.cumsum(np.stack([np.cos(turn), np.sin(turn)], axis=-1) * step[:, None], axis=0)
    level = 150.0 + rng.choice((-1.0, 1.0)) * rng.uniform(8.0, 30.0)
    cv2.polylines(floor, [np.rint(line * 16).astype(np.int32)], False, (level, level, level), 1, cv2.LINE_AA, 4)


def _grid(shape: tuple[int, int], texel_m: float, rng: Rng) -> Field:
    """Light, with dark lines every 5 cm."""
    floor = _grey(165.0, 2.0 * noise(shape, 0.2 / texel_m, rng), 1.2 * noise(shape, 3.0, rng))
    y, x = (((np.arange(size) + 0.5) * texel_m) for size in shape)
    on_line = (np.abs((y + GRID_M / 2) % GRID_M - GRID_M / 2) < LINE_M / 2)[:, None] | (
        np.abs((x + GRID_M / 2) % GRID_M - GRID_M / 2) < LINE_M / 2
    )[None, :]
    lines = cv2.GaussianBlur(on_line.astype(np.float32), (3, 3), 0)[..., None]
    return np.asarray(floor * (1.0 - lines) * (0.965, 1.0, 1.005) + 75.0 * lines, np.float32)


def _wood(shape: tuple[int, int], texel_m: float, rng: Rng) -> Field:
    """Planks along x, each in its own tone, with grain and dark grooves."""
    y, x = (((np.arange(size) + 0.5) * texel_m) for size in shape)
    plank = np.floor(y / PLANK_M).astype(int)
    shift = rng.uniform(0.0, PLANK_LENGTH_M, plank.max() + 1)[plank]
    piece = np.floor((x[None, :] + shift[:, None]) / PLANK_LENGTH_M).astype(int)
    tones = rng.normal(0.0, 0.07, (plank.max() + 1, piece.max() + 1))[plank[:, None], piece]
    fine, coarse = noise((shape[0], max(2, shape[1] // 24)), 2.0, rng), noise((shape[0], max(2, shape[1] // 12)), 8.0, rng)
    grain = sum(weight * cv2.resize(layer, shape[::-1], interpolation=cv2.INTER_LINEAR) for weight, layer in ((0.04, fine), (0.05, coarse)))
    groove = (np.abs((y + PLANK_M / 2) % PLANK_M - PLANK_M / 2) < GROOVE_M)[:, None] | (
        (x[None, :] + shift[:, None]) % PLANK_LENGTH_M < 2.0 * GROOVE_M
    )
    brightness = (1.0 + tones + grain) * np.where(groove, 0.55, 1.0)
    return np.asarray(np.array([88.0, 130.0, 172.0]) * brightness[..., None], np.float32)


def _concrete(shape: tuple[int, int], texel_m: float, rng: Rng) -> Field:
    """Blotches of all sizes, and pores."""
    layers = [weight * noise(shape, size_m / texel_m, rng) for weight, size_m in ((7.0, 0.4), (5.0, 0.1), (4.0, 0.03), (3.0, 0.008))]
    pores = np.where(noise(shape, 0.006 / texel_m, rng) > 2.6, -30.0, 0.0).astype(np.float32)
    return _grey(128.0, *layers, pores)


def _plain(shape: tuple[int, int], texel_m: float, rng: Rng) -> Field:
    return np.asarray(1.0 + 0.01 * noise(shape, 0.05 / texel_m, rng), np.float32)


def _card(shape: tuple[int, int], texel_m: float, rng: Rng) -> Field:
    """Cardboard: fibres, a strip of tape, a label."""
    face = 1.0 + 0.03 * noise(shape, 3.0, rng) + 0.03 * noise(shape, 0.03 / texel_m, rng)
    rows, cols = shape
    face[round(0.44 * rows) : round(0.56 * rows)] *= 1.12
    face[round(0.65 * rows) : round(0.9 * rows), round(0.08 * cols) : round(0.35 * cols)] = 1.55
    return np.asarray(face, np.float32)


def _stripes(shape: tuple[int, int], texel_m: float, rng: Rng) -> Field:
    """Light and dark squares, as on printed test bodies."""
    y, x = (np.floor((np.arange(size) + 0.5) * texel_m / STRIPE_M).astype(int) for size in shape)
    light = (y[:, None] + x[None, :]) % 2 == 0
    return np.asarray(np.where(light, 1.0, 0.15) + 0.01 * noise(shape, 3.0, rng), np.float32)


def _speckle(shape: tuple[int, int], texel_m: float, rng: Rng) -> Field:
    """Irregular spots in two tones."""
    return np.asarray(np.where(noise(shape, SPECKLE_M / texel_m, rng) > 0.3, 1.0, 0.55), np.float32)


_FLOORS: Mapping[FloorKind, Callable[[tuple[int, int], float, Rng], Field]] = {
    "paint": _paint,
    "grid": _grid,
    "wood": _wood,
    "concrete": _concrete,
}
_MATERIALS: Mapping[Material, Callable[[tuple[int, int], float, Rng], Field]] = {
    "plain": _plain,
    "card": _card,
    "stripes": _stripes,
    "speckle": _speckle,
}
