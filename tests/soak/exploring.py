"""One random arena explored in lockstep by real processes, and how much of the floor that a robot can reach is known, by the truth."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import shapely
import yaml
from numpy.typing import NDArray

from deploy.scenario_plan import arena_arguments
from deploy.simulation import Display
from mapserver.export import PIXELS
from protocol.geometry import Array
from sim.arena import BOUNDS_M, NARROW_RADIUS_M, random_arena
from sim.free_floor import CELL_M, FreeFloor
from sim.scenario import Scenario
from sim.staging import obstacles_of
from tests.soak.arenas import collisions_in, driven, ending_of

MOST_S = 240.0  # of world time: who is not home by then is stuck


@dataclass(frozen=True)
class ExploredArena:
    """What came of one arena."""

    seed: int
    robots: int
    is_home: bool
    world_s: float
    wall_s: float
    collisions: int
    known_share: float  # of the floor that a robot can reach, 0 to 1
    ending: str  # the formation's last phase, and its reason


def explore_arena(seed: int, robots: int, folder: Path, display: Display, most_s: float = MOST_S) -> ExploredArena:
    """Explore the arena, leave the run in its folder, and return the result; raises OmmatidiaError where that cannot go on."""
    scenario = random_arena(seed, robots)
    moment, told = driven(scenario.model_copy(update={"goals_m": ()}), arena_arguments(seed, robots), folder, display, most_s)
    state = moment.formation
    return ExploredArena(
        seed=seed,
        robots=robots,
        is_home=state is not None and state.phase == "arrived",
        world_s=moment.world_s,
        wall_s=moment.wall_s,
        collisions=collisions_in(told),
        known_share=known_share(folder, scenario),
        ending=ending_of(state),
    )


def known_share(run: Path, scenario: Scenario) -> float:
    """Return the share, 0 to 1, of the floor that a robot can reach from the first one's start that a run's grid does not leave unknown."""
    floor = FreeFloor(BOUNDS_M, [shapely.Polygon(thing.footprint_m) for thing in obstacles_of(scenario)])
    start = scenario.robots[0].start
    rows, columns = np.nonzero(floor.reachable((start[0], start[1]), NARROW_RADIUS_M))
    centres_m = np.array(BOUNDS_M[:2]) + CELL_M * (np.column_stack([columns, rows]) + 0.5)
    return float((_grid_at(run, centres_m) != PIXELS[0]).mean())


def _grid_at(run: Path, points_m: Array) -> NDArray[np.uint8]:
    """Return a run's grid, as in map.pgm, at points, shape (n, 2) [m; arena]; unknown beyond its edges."""
    grid = cv2.imread(str(run / "map.pgm"), cv2.IMREAD_GRAYSCALE)
    assert grid is not None, f"{run} has no map.pgm"
    about = yaml.safe_load((run / "map.yaml").read_text(encoding="utf-8"))
    columns, up = np.floor((points_m - np.array(about["origin"][:2])) / about["resolution"]).astype(int).T
    rows = grid.shape[0] - 1 - up
    inside = (columns >= 0) & (columns < grid.shape[1]) & (rows >= 0) & (rows < grid.shape[0])
    return np.asarray(np.where(inside, grid[rows * inside, columns * inside], PIXELS[0]), dtype=np.uint8)
