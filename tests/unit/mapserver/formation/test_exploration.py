"""Where to look next, and a whole exploration in the test bed."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from mapserver.formation.costmap import CostMap, cost_map
from mapserver.formation.exploration import Frontiers
from mapserver.formation.floor import Floor
from mapserver.formation.planning import Berth, Reach
from mapserver.formation.shapes import Shape
from mapserver.formation.task import Task
from protocol.geometry import Pose2
from protocol.messages import FREE, OCCUPIED, UNKNOWN
from tests.unit.mapserver.formation.arenas import BOUNDS, CELL_M, ORIGIN_M, Arena, random_arena
from tests.unit.mapserver.formation.bed import RADIUS_M, Bed, loose_wedge

BERTH = Berth(0.11, 0.35)
LEADER = Pose2(1.0, 1.5, 0.0)


def half_known() -> NDArray[np.uint8]:
    """Return cells that are bare up to x = 2 m and unknown beyond."""
    cells = np.full((300, 400), FREE, np.uint8)
    cells[:, 200:] = UNKNOWN
    return cells


def on(cells: NDArray[np.uint8]) -> CostMap:
    return cost_map(Floor(cells, ORIGIN_M, CELL_M), BOUNDS, np.array([LEADER[:2]]), [])


def reach(scene: CostMap) -> Reach:
    return Reach(scene, np.array(LEADER[:2]), BERTH)


def test_a_lookout_lies_on_known_floor_and_sees_the_dark() -> None:
    scene = on(half_known())
    lookout = Frontiers().best(scene, reach(scene), LEADER)
    assert lookout is not None
    assert lookout.place_m[0] < 2.0
    assert lookout.dark_m[0] == pytest.approx(2.0, abs=0.05)
    assert math.dist(lookout.place_m, lookout.dark_m) < 0.9


def test_nothing_is_looked_at_through_a_wall() -> None:
    cells = half_known()
    cells[:, 195:200] = OCCUPIED
    scene = on(cells)
    assert Frontiers().best(scene, reach(scene), LEADER) is None


def test_slivers_and_what_stayed_dark_are_left_alone() -> None:
    cells = np.full((300, 400), FREE, np.uint8)
    cells[:, 200:203] = UNKNOWN
    scene = on(cells)
    assert Frontiers().best(scene, reach(scene), LEADER) is None
    cells[100:120, 200:220] = UNKNOWN
    scene, frontiers = on(cells), Frontiers()
    for _ in range(10):
        if (lookout := frontiers.best(scene, reach(scene), LEADER)) is None:
            break
        frontiers.ban(lookout)
    assert lookout is None


def test_a_lookout_is_done_with_when_its_dark_is_lit() -> None:
    scene = on(half_known())
    lookout = Frontiers().best(scene, reach(scene), LEADER)
    assert lookout is not None
    assert Frontiers().is_dark(scene, lookout)
    assert not Frontiers().is_dark(on(np.full((300, 400), FREE, np.uint8)), lookout)


def reachable(arena: Arena) -> NDArray[np.bool_]:
    """Return the floor that a body can cover, from where the leader starts."""
    cells = arena.cells(np.zeros(len(arena.things)))
    truth = cost_map(Floor(cells, ORIGIN_M, CELL_M), BOUNDS, np.array([arena.start[:2]]), [])
    _, labels = cv2.connectedComponents((truth.clearances_m > RADIUS_M + 0.03).astype(np.uint8))
    column, row = np.floor((np.array(arena.start[:2]) - ORIGIN_M) / CELL_M).astype(int)
    bodies = (labels == labels[row, column]).astype(np.uint8)
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (15, 15))
    return np.asarray((cv2.dilate(bodies, disc) > 0) & (cells == FREE))


@pytest.mark.slow
@pytest.mark.timeout(600)
@pytest.mark.parametrize("seed", range(3))
def test_an_arena_is_explored_and_the_swarm_comes_home(seed: int) -> None:
    arena = random_arena(seed)
    task = Task(shape=Shape("column", 0.35), leader="r1", explores=True, bounds=BOUNDS)
    bed = Bed(arena, task, loose_wedge(arena, task, 3, np.random.default_rng(seed)), seed)
    home = bed.robots["r1"].pose
    assert bed.run(500.0).phase == "arrived"
    assert bed.known_share(reachable(arena)) >= 0.98
    assert min(math.dist(robot.pose[:2], home[:2]) for robot in bed.robots.values()) < 0.05
    assert bed.collisions == []
