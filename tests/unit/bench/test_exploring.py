"""How much of the floor a run's grid knows."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mapserver.export import PIXELS, GridPicture, map_yaml, pgm
from sim.arena import BOUNDS_M, random_arena
from tests.soak.exploring import known_share

CELL_M = 0.02
SHAPE = (150, 200)


def write_grid(folder: Path, known_columns: int) -> None:
    """Write a grid of the arena that knows its first columns."""
    pixels = np.full(SHAPE, PIXELS[0])
    pixels[:, :known_columns] = PIXELS[1]
    picture = GridPicture(pixels, (BOUNDS_M[0], BOUNDS_M[1]), CELL_M)
    (folder / "map.pgm").write_bytes(pgm(picture))
    (folder / "map.yaml").write_text(map_yaml(picture, "map.pgm"), encoding="utf-8")


@pytest.mark.parametrize(("columns", "least", "most"), [(0, 0.0, 0.0), (100, 0.35, 0.65), (200, 1.0, 1.0)])
def test_the_known_share_is_that_of_the_floor_a_robot_can_reach(tmp_path: Path, columns: int, least: float, most: float) -> None:
    write_grid(tmp_path, columns)
    assert least <= known_share(tmp_path, random_arena(1, 3)) <= most


def test_what_lies_beyond_the_grid_is_unknown(tmp_path: Path) -> None:
    picture = GridPicture(np.full((1, 1), PIXELS[1]), (0.0, 0.0), CELL_M)
    (tmp_path / "map.pgm").write_bytes(pgm(picture))
    (tmp_path / "map.yaml").write_text(map_yaml(picture, "map.pgm"), encoding="utf-8")
    assert known_share(tmp_path, random_arena(1, 3)) < 0.001
