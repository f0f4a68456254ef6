"""Floors of the made-up room, as pictures of seeded noise and lines: the same place of the arena looks the same from everywhere."""

from __future__ import annotations

from functools import cache

import cv2
import numpy as np
from numpy.typing import NDArray

CELL_M = 0.003
SIDE_CELLS = 2048  # 6.1 m; the arena's origin is in the middle. Rows run along x, columns along y
LEVELS = 6
TEXTURED = ("paint", "grid", "wood", "concrete")

_Field = NDArray[np.float32]


@cache
def floor_atlas(name: str) -> NDArray[np.uint8]:
    """Return a floor, BGR, beside its own copies of half, quarter, ... size, one under the other."""
    level = np.clip(_FLOORS[name](np.random.default_rng(len(name))), 0, 255).astype(np.uint8)
    atlas = np.zeros((SIDE_CELLS, SIDE_CELLS + SIDE_CELLS // 2, 3), np.uint8)
    atlas[:, :SIDE_CELLS] = level
    row = 0
    for _ in range(1, LEVELS):
        size = level.shape[0] // 2
        level = np.asarray(cv2.resize(level, (size, size), interpolation=cv2.INTER_AREA), np.uint8)
        atlas[row : row + size, SIDE_CELLS : SIDE_CELLS + size] = level
        row += size
    return atlas


def _noise(rng: np.random.Generator, along_m: float, across_m: float) -> _Field:
    """Return smooth noise of about unit size over the whole floor, from a lattice with these spacings."""
    rows, cols = (max(4, round(SIDE_CELLS * CELL_M / step)) for step in (along_m, across_m))
    lattice = rng.standard_normal((rows, cols), dtype=np.float32)
    return np.asarray(cv2.resize(lattice, (SIDE_CELLS, SIDE_CELLS), interpolation=cv2.INTER_CUBIC), np.float32)


def _painted(colour: tuple[float, float, float], shade: _Field) -> _Field:
    return np.asarray(shade[..., None] * np.asarray(colour, np.float32), np.float32)


def _lines(mesh_m: float, width_m: float) -> _Field:
    """Return how much of each cell, (SIDE_CELLS,), lines at every multiple of `mesh_m` cover."""
    at = (np.arange(SIDE_CELLS) + 0.5 - SIDE_CELLS / 2) * CELL_M
    off = np.abs(at - mesh_m * np.round(at / mesh_m))
    return np.clip((0.5 * (width_m + CELL_M) - off) / CELL_M, 0.0, min(1.0, width_m / CELL_M)).astype(np.float32)


def _paint(rng: np.random.Generator) -> _Field:
    """Matte grey paint with speckle and scratches."""
    shade = 1.0 + 0.015 * _noise(rng, 0.4, 0.4) + 0.05 * _noise(rng, 0.006, 0.006)
    scratches = np.zeros(shade.shape, np.float32)
    for row, col, turn, length in rng.uniform((0, 0, 0, 20), (SIDE_CELLS, SIDE_CELLS, 2 * np.pi, 120), (700, 4)):
        end = (int(col + length * np.cos(turn)), int(row + length * np.sin(turn)))
        cv2.line(scratches, (int(col), int(row)), end, 1.0, 1)
    return _painted((168.0, 172.0, 175.0), shade * (1.0 - 0.15 * cv2.blur(scratches, (2, 2))))


def _grid(rng: np.random.Generator) -> _Field:
    """White sheet with dark lines every 5 cm."""
    lines = np.maximum.outer(_lines(0.05, 0.003), _lines(0.05, 0.003))
    shade = (1.0 + 0.01 * _noise(rng, 0.006, 0.006)) * (1.0 - 0.65 * lines)
    return _painted((205.0, 208.0, 210.0), shade.astype(np.float32))


def _wood(rng: np.random.Generator) -> _Field:
    """Planks 12 cm wide along x with grain, no two of quite the same shade."""
    at = (np.arange(SIDE_CELLS) + 0.5) * CELL_M
    row = np.floor(at / 0.12).astype(np.intp)
    along = at[:, None] + rng.uniform(0.0, 0.9, row[-1] + 1)[row][None, :]
    plank = np.floor(along / 0.9).astype(np.intp)
    shade = rng.uniform(0.9, 1.1, (plank.max() + 1, row[-1] + 1))[plank, row[None, :]]
    warmth = rng.uniform(-0.015, 0.015, (plank.max() + 1, row[-1] + 1))[plank, row[None, :]]
    grain = 0.06 * _noise(rng, 0.12, 0.006) + 0.02 * _noise(rng, 0.006, 0.006)
    gap = np.maximum(np.remainder(at, 0.12)[None, :] < CELL_M, np.remainder(along, 0.9) < CELL_M)
    colours = _painted((92.0, 130.0, 165.0), (shade * (1.0 + grain) * (1.0 - 0.4 * gap)).astype(np.float32))
    return np.asarray(colours * np.stack([1.0 - warmth, np.ones_like(warmth), 1.0 + warmth], axis=-1), np.float32)


def _concrete(rng: np.random.Generator) -> _Field:
    """Grey with mottling of every size."""
    mottling = sum(amount * _noise(rng, size, size) for size, amount in ((0.5, 0.03), (0.15, 0.03), (0.05, 0.03), (0.015, 0.035)))
    return _painted((138.0, 142.0, 143.0), np.asarray(1.0 + mottling + 0.03 * _noise(rng, 0.006, 0.006), np.float32))


def _blank(rng: np.random.Generator) -> _Field:
    """One colour, and nothing to hold on to."""
    return _painted((170.0, 172.0, 174.0), np.ones((SIDE_CELLS, SIDE_CELLS), np.float32))


_FLOORS = {"paint": _paint, "grid": _grid, "wood": _wood, "concrete": _concrete, "blank": _blank}
