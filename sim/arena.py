"""Random arenas, each the same for ever by its seed: the swarm starts at one end, its goal is at the other, and a barrier lies between.

The barrier is a row of obstacles from wall to wall. Each gap in it lets one robot through, but no wedge. On both sides of it obstacles
stand so that the wedge finds a way. What is thrown is checked, and thrown again until all of that holds.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import shapely

from protocol.errors import ConfigError
from protocol.geometry import Pose2
from sim.arena_robots import BODY_RADIUS_M, LARGEST_GROUP, WEDGE_RADIUS_M, group_places, random_robots, wedge_places
from sim.arena_things import Block, random_barrier, random_block, tables_of
from sim.free_floor import FreeFloor
from sim.scenario import ArenaTable, Scenario
from sim.scenario_robots import RobotTable
from sim.world.scene import FloorKind

# The arenas that every version of the swarm has to master: (seed, robots).
SOAK = (*((seed, 3) for seed in range(1, 21)), *((seed, 6) for seed in range(21, 26)))

ARENA = ArenaTable()
BOUNDS_M = (ARENA.x_min_m, ARENA.y_min_m, ARENA.x_max_m, ARENA.y_max_m)
OBSTACLES = (8, 12)  # fewest and most
COVERED = (0.05, 0.20)  # part of the floor, least and most
APART_M = 0.32  # between any two obstacles, and to the walls: whatever looks like a passage is one
GOAL_AWAY_M = 2.5
NARROW_RADIUS_M = BODY_RADIUS_M + 0.06  # what passes every gap
START_ROOM_M, SLOT_ROOM_M = 0.15, 0.10  # from a body's edge to the nearest obstacle, at the start and at the goal
WALL_ROOM_M = 0.05  # from a body's edge to the nearest wall, at the start
GOAL_ROOM_M = 0.55  # around the goal's point
BARRIER_ROOM_M = 0.55  # the wedge gets so near to the barrier's line, on both sides

_THROWS = 4000
_BLOCK_THROWS = 150
_LARGEST_WEDGE = 6
_FLOOR = shapely.box(*BOUNDS_M)
_FLOORS: tuple[FloorKind, ...] = ("grid", "paint", "wood", "concrete")
_DURATION_S = 90.0


@dataclass(frozen=True)
class _Zone:
    """Where a swarm of up to so many robots starts, is held up and arrives, each from least to most."""

    robots: int
    start_x_m: tuple[float, float]
    beside_m: float  # start and goal are at most so far from the arena's long axis
    barrier_x_m: tuple[float, float]
    goal_x_m: tuple[float, float]


_ZONES = (
    _Zone(3, (-1.30, -1.10), 0.7, (-0.10, 0.25), (1.20, 1.40)),
    _Zone(6, (-1.05, -0.95), 0.7, (-0.20, 0.00), (1.40, 1.65)),
    _Zone(LARGEST_GROUP, (-0.84, -0.78), 0.2, (0.00, 0.05), (1.60, 1.70)),
)


@dataclass(frozen=True)
class _Layout:
    """One throw."""

    leader: Pose2
    goal_m: tuple[float, float]
    barrier_x_m: float
    blocks: tuple[Block, ...]


def random_arena(seed: int, robots: int) -> Scenario:
    """Return the arena of this seed, 4 x 3 m, for 1 to 12 robots. Raises ConfigError for more."""
    if not 1 <= robots <= LARGEST_GROUP:
        raise ConfigError(f"a random arena has room for 1 to {LARGEST_GROUP} robots, not {robots}")
    rng = np.random.default_rng([seed, robots])
    for _ in range(_THROWS):
        layout = _throw(rng, robots)
        if layout is not None and _is_fair(layout, robots):
            return _scenario(rng, seed, layout, random_robots(rng, layout.leader, robots))
    raise ConfigError(f"no arena was found for seed {seed} and {robots} robots; take another seed")


def _throw(rng: np.random.Generator, robots: int) -> _Layout | None:
    """Return one throw, or None where not all obstacles found room."""
    zone = next(zone for zone in _ZONES if robots <= zone.robots)
    leader_at_m = (rng.uniform(*zone.start_x_m), rng.uniform(-zone.beside_m, zone.beside_m))
    goal_m = (rng.uniform(*zone.goal_x_m), rng.uniform(-zone.beside_m, zone.beside_m))
    if math.dist(leader_at_m, goal_m) < GOAL_AWAY_M:
        return None
    leader = Pose2(*leader_at_m, math.atan2(goal_m[1] - leader_at_m[1], goal_m[0] - leader_at_m[0]))
    barrier_x_m = rng.uniform(*zone.barrier_x_m)
    barrier = random_barrier(rng, barrier_x_m, BOUNDS_M)
    taken = shapely.union_all([_start_room(leader, robots), _goal_room(leader, goal_m, robots)])
    blocks = _fill(rng, barrier, taken)
    return None if blocks is None else _Layout(leader, goal_m, barrier_x_m, blocks)


def _fill(rng: np.random.Generator, barrier: list[Block] | None, taken: shapely.Geometry) -> tuple[Block, ...] | None:
    """Return the barrier and obstacles on both sides of it, or None where these do not find room."""
    if barrier is None or any(block.polygon.intersects(taken) for block in barrier):
        return None
    blocks = list(barrier)
    count = int(rng.integers(OBSTACLES[0], OBSTACLES[1] + 1))
    room = _FLOOR.buffer(-APART_M)
    for _ in range(_BLOCK_THROWS):
        if len(blocks) == count:
            return tuple(blocks)
        block = random_block(rng, BOUNDS_M)
        stands_free = room.contains(block.polygon) and not block.polygon.intersects(taken)
        if stands_free and all(block.polygon.distance(other.polygon) >= APART_M for other in blocks):
            blocks.append(block)
    return None


def _start_room(leader: Pose2, robots: int) -> shapely.Geometry:
    """Return the floor that no obstacle may cover so that all robots can stand at their start."""
    return _points(group_places(leader, robots)).buffer(BODY_RADIUS_M + START_ROOM_M)


def _goal_room(leader: Pose2, goal_m: tuple[float, float], robots: int) -> shapely.Geometry:
    """Return the floor that no obstacle may cover so that the formation can stand at the goal, heading as it did at the start.

    A swarm for whose wedge there is no room anyway has to find another formation there.
    """
    arrived = Pose2(*goal_m, leader.theta_rad)
    formations = [*wedge_places(arrived, robots), *group_places(arrived, robots)] if robots <= _LARGEST_WEDGE else [arrived]
    places = _points(formations).buffer(BODY_RADIUS_M + SLOT_ROOM_M)
    return shapely.union(places, shapely.Point(goal_m).buffer(GOAL_ROOM_M))


def _points(poses: Iterable[Pose2]) -> shapely.MultiPoint:
    return shapely.MultiPoint([(pose.x_m, pose.y_m) for pose in poses])


def _is_fair(layout: _Layout, robots: int) -> bool:
    """Tell whether enough floor is covered, nobody starts in a wall, and the barrier holds up the wedge and nobody else."""
    polygons = [block.polygon for block in layout.blocks]
    covered = sum(polygon.area for polygon in polygons) / _FLOOR.area
    starts = _points(group_places(layout.leader, robots))
    return (
        COVERED[0] <= covered <= COVERED[1]
        and _FLOOR.buffer(-BODY_RADIUS_M - WALL_ROOM_M).contains(starts)
        and _barrier_is_fair(FreeFloor(BOUNDS_M, polygons), layout)
    )


def _barrier_is_fair(floor: FreeFloor, layout: _Layout) -> bool:
    """Tell whether one robot reaches the goal and the wedge does not, but comes near the barrier from both sides."""
    start_m = (layout.leader.x_m, layout.leader.y_m)
    before_m = floor.columns(floor.reachable(start_m, WEDGE_RADIUS_M))
    behind_m = floor.columns(floor.reachable(layout.goal_m, WEDGE_RADIUS_M))
    return (
        floor.is_reachable(start_m, layout.goal_m, NARROW_RADIUS_M)
        and not floor.is_reachable(start_m, layout.goal_m, WEDGE_RADIUS_M)
        and bool(before_m.size and before_m.max() >= layout.barrier_x_m - BARRIER_ROOM_M)
        and bool(behind_m.size and behind_m.min() <= layout.barrier_x_m + BARRIER_ROOM_M)
    )


def _scenario(rng: np.random.Generator, seed: int, layout: _Layout, robots: tuple[RobotTable, ...]) -> Scenario:
    boxes, cylinders = tables_of(rng, layout.blocks)
    return Scenario(
        name=f"arena-{seed}",
        seed=seed,
        duration_s=_DURATION_S,
        goals_m=(layout.goal_m,),
        arena=ARENA.model_copy(update={"floor": _FLOORS[int(rng.integers(len(_FLOORS)))]}),
        boxes=boxes,
        cylinders=cylinders,
        robots=robots,
    )
