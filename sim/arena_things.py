"""What stands in a random arena: boxes and cylinders of any size, and the barrier that only a column can pass."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
import shapely

from sim.footprints import box_footprint, cylinder_footprint
from sim.scenario import BoxTable, CylinderTable
from sim.world.scene import Material

Bounds = tuple[float, float, float, float]  # x min, y min, x max, y max [m]

GAP_M = (0.34, 0.48)  # of the barrier, least and most; a robot is 0.15 m wide, the wedge 0.61 m
HEIGHT_M = (0.05, 0.25)

_MATERIALS: tuple[Material, ...] = ("plain", "card", "stripes", "speckle")
_RGBS = (
    (181, 137, 91),
    (176, 32, 34),
    (28, 62, 150),
    (36, 120, 52),
    (214, 176, 24),
    (226, 226, 220),
    (46, 46, 50),
    (196, 98, 22),
    (110, 52, 128),
    (24, 132, 140),
)
_SHIFTS = 40


@dataclass(frozen=True)
class Block:
    """The place and size of one obstacle: a box, or a cylinder as wide as long."""

    shape: str  # "box" or "cylinder"
    centre_m: tuple[float, float]
    size_m: tuple[float, float]
    yaw_rad: float

    @property
    def polygon(self) -> shapely.Polygon:
        """Return the footprint."""
        table = self.table()
        return shapely.Polygon(box_footprint(table) if isinstance(table, BoxTable) else cylinder_footprint(table))

    def table(
        self, height_m: float = HEIGHT_M[0], rgb: tuple[int, int, int] = _RGBS[0], material: Material = "plain"
    ) -> BoxTable | CylinderTable:
        """Return the obstacle as a scenario has it."""
        if self.shape == "box":
            return BoxTable(centre_m=self.centre_m, size_m=self.size_m, yaw_rad=self.yaw_rad, height_m=height_m, rgb=rgb, material=material)
        return CylinderTable(centre_m=self.centre_m, radius_m=0.5 * self.size_m[0], height_m=height_m, rgb=rgb, material=material)


def random_block(rng: np.random.Generator, bounds_m: Bounds) -> Block:
    """Return an obstacle anywhere within the bounds."""
    x_m, y_m = rng.uniform(bounds_m[:2], bounds_m[2:]).tolist()
    if rng.random() < 0.4:
        size_m = rng.uniform(0.14, 0.30)
        return Block("cylinder", (x_m, y_m), (size_m, size_m), 0.0)
    size = rng.uniform((0.18, 0.14), (0.42, 0.34)).tolist()
    return Block("box", (x_m, y_m), (size[0], size[1]), rng.uniform(-math.pi, math.pi))


def random_barrier(rng: np.random.Generator, x_m: float, bounds_m: Bounds) -> list[Block] | None:
    """Return a row of three or four obstacles near x_m with gaps of `GAP_M` between them and to both walls, or None where that fails."""
    count = int(rng.integers(3, 5))
    y_min_m, y_max_m = bounds_m[1], bounds_m[3]
    gaps_m = rng.uniform(*GAP_M, count + 1)
    share = rng.uniform(0.8, 1.2, count)
    lengths_m = (y_max_m - y_min_m - gaps_m.sum()) * share / share.sum()
    row: list[Block] = []
    before: shapely.Geometry = shapely.LineString([(bounds_m[0], y_min_m), (bounds_m[2], y_min_m)])
    for length_m, gap_m in zip(lengths_m.tolist(), gaps_m.tolist(), strict=False):
        block = _beyond(_barrier_block(rng, x_m, length_m), before, gap_m)
        row.append(block)
        before = block.polygon
    last_gap_m = y_max_m - shapely.bounds(before)[3]
    return row if GAP_M[0] <= last_gap_m <= GAP_M[1] else None


def tables_of(rng: np.random.Generator, blocks: Iterable[Block]) -> tuple[tuple[BoxTable, ...], tuple[CylinderTable, ...]]:
    """Return boxes and cylinders, each of some height, colour and material."""
    tables = [
        block.table(round(rng.uniform(*HEIGHT_M), 3), _RGBS[int(rng.integers(len(_RGBS)))], _MATERIALS[int(rng.integers(len(_MATERIALS)))])
        for block in blocks
    ]
    boxes = tuple(table for table in tables if isinstance(table, BoxTable))
    return boxes, tuple(table for table in tables if isinstance(table, CylinderTable))


def _barrier_block(rng: np.random.Generator, x_m: float, length_m: float) -> Block:
    """Return an obstacle that is about so long across the arena, at no height of it yet."""
    at_m = (x_m + rng.uniform(-0.04, 0.04), 0.0)
    if length_m < 0.34 and rng.random() < 0.5:
        return Block("cylinder", at_m, (length_m, length_m), 0.0)
    return Block("box", at_m, (rng.uniform(0.16, 0.28), length_m), rng.uniform(-0.15, 0.15))


def _beyond(block: Block, before: shapely.Geometry, gap_m: float) -> Block:
    """Return the block moved up along y until it is `gap_m` away from what lies before it."""
    low_m, high_m = shapely.bounds(before)[3], shapely.bounds(before)[3] + gap_m + max(block.size_m)
    for _ in range(_SHIFTS):
        middle_m = 0.5 * (low_m + high_m)
        block = replace(block, centre_m=(block.centre_m[0], middle_m))
        if block.polygon.distance(before) < gap_m:
            low_m = middle_m
        else:
            high_m = middle_m
    return block
