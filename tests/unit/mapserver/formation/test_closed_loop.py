"""The whole formation in the test bed: robots that lag, poses that are a little wrong, a grid that is uncovered as they go."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
import shapely

from mapserver.formation.controller import Orders
from mapserver.formation.shapes import Shape
from mapserver.formation.task import Task
from protocol.geometry import Pose2
from tests.unit.mapserver.formation.arenas import BARRIER_M, BOUNDS, Arena, random_arena
from tests.unit.mapserver.formation.bed import STEP_S, Bed, Record, Unicycle, loose_wedge, rms_m

WEDGE = Shape("wedge", distance_m=0.40, angle_rad=0.6)


def bed_in(arena: Arena, shape: Shape = WEDGE, count: int = 3, seed: int = 0, explores: bool = False) -> Bed:
    task = Task(shape=shape, leader="r1", goals=(arena.goal_m,), bounds=BOUNDS, explores=explores)
    return Bed(arena, task, loose_wedge(arena, task, count, np.random.default_rng(seed)), seed)


def bare(goal_m: tuple[float, float] = (3.4, 1.5), *things: shapely.Polygon) -> Arena:
    return Arena(things, Pose2(0.8, 1.5, 0.0), goal_m, 0.0)


def gate(gap_m: float) -> Arena:
    """Return an arena that is bare but for a wall with a gap in its middle."""
    lower = shapely.box(2.0, 0.0, 2.0 + BARRIER_M, 1.5 - 0.5 * gap_m)
    return bare((3.6, 1.5), lower, shapely.box(2.0, 1.5 + 0.5 * gap_m, 2.0 + BARRIER_M, 3.0))


def arrives(bed: Bed, within_s: float = 120.0) -> None:
    orders = bed.run(within_s)
    assert orders.phase == "arrived", (orders.phase, orders.reason)
    assert bed.collisions == []


def is_open(record: Record) -> bool:
    """Tell whether nobody gives way."""
    return record.orders.phase == "moving"


def test_on_bare_floor_the_wedge_is_kept_to_a_centimetre() -> None:
    bed = bed_in(bare())
    arrives(bed)
    assert math.dist(bed.robots["r1"].pose[:2], (3.4, 1.5)) < 0.05
    assert rms_m(bed.records, "moving") < 0.01
    assert sum(is_open(record) for record in bed.records) * STEP_S > 12.0


@pytest.mark.parametrize("gap_m", [pytest.param(0.32, marks=pytest.mark.slow), 0.4])
def test_it_narrows_to_a_column_for_a_gap_and_opens_again_within_five_seconds(gap_m: float) -> None:
    bed = bed_in(gate(gap_m))
    arrives(bed)
    through = next(
        step for step, record in enumerate(bed.records) if min(pose.x_m for pose in record.poses.values()) > 2.0 + BARRIER_M + 0.075
    )
    opened = next(step for step, record in enumerate(bed.records) if step > through and is_open(record))
    assert (opened - through) * STEP_S <= 5.0
    assert rms_m(bed.records, "avoiding") < 0.03
    assert bed.closest_m > 0.25


def test_the_leader_turns_aside_for_an_obstacle_and_the_others_follow() -> None:
    bed = bed_in(bare((3.4, 1.5), shapely.Point(2.0, 1.5).buffer(0.12)))
    arrives(bed)
    assert max(abs(record.poses["r1"].y_m - 1.5) for record in bed.records) > 0.15
    assert rms_m(bed.records, "avoiding") < 0.02


@pytest.mark.slow
def test_references_never_jump_and_never_run_backwards() -> None:
    bed = bed_in(random_arena(6), seed=6)
    arrives(bed)
    under_way = [record for record in bed.records if record.orders.phase in ("moving", "avoiding")]
    for before, after in itertools.pairwise(under_way):
        for name, reference in after.orders.references.items():
            last = before.orders.references[name]
            moved_m = math.dist(reference.arena_from_body[:2], last.arena_from_body[:2])
            assert moved_m <= 0.25 * STEP_S
            assert -1e-3 <= reference.speed_m_s <= 0.23
            assert abs(reference.turn_rad_s) < 1.3


@pytest.mark.slow
@pytest.mark.parametrize(
    "shape", [Shape("column", 0.35), Shape("line", 0.4), Shape("polygon", 0.4), Shape("free", offsets=((0.3, 0.2), (0.5, 0.0)))]
)
def test_every_shape_gets_through_the_gate(shape: Shape) -> None:
    bed = bed_in(gate(0.36), shape)
    arrives(bed, 150.0)


def lose(bed: Bed, robot: str, after_s: float) -> None:
    """Drive for a while, and then lose a robot."""
    bed.run(after_s)
    assert bed.records[-1].orders.phase in ("moving", "avoiding")
    bed.present.discard(robot)


@pytest.mark.slow
def test_without_a_follower_the_others_close_ranks_and_go_on() -> None:
    bed = bed_in(bare(), Shape("column", 0.35))
    lose(bed, "r2", 12.0)
    arrives(bed)
    assert set(bed.records[-1].orders.slots) == {"r1", "r3"}
    assert bed.records[-1].orders.slots["r3"][0] == pytest.approx(-0.35, abs=0.02)


@pytest.mark.slow
def test_without_its_leader_the_next_one_leads() -> None:
    bed = bed_in(bare())
    lose(bed, "r1", 12.0)
    arrives(bed)
    last = bed.records[-1]
    assert last.orders.leader in ("r2", "r3")
    assert math.dist(last.poses[last.orders.leader][:2], (3.4, 1.5)) < 0.3


@pytest.mark.slow
def test_a_robot_that_returns_takes_its_slot_again() -> None:
    bed = bed_in(bare())
    lose(bed, "r3", 10.0)
    bed.run(8.0)
    bed.present.add("r3")
    arrives(bed)
    assert set(bed.records[-1].orders.slots) == {"r1", "r2", "r3"}
    assert max(bed.records[-1].errors_m.values()) < 0.03


def test_a_stop_holds_all_and_a_release_goes_on() -> None:
    bed = bed_in(bare())
    bed.run(12.0)
    bed.stopped = "by hand"
    bed.run(1.0)
    held = dict(bed.records[-1].poses)
    orders = bed.run(3.0)
    assert (orders.phase, orders.reason, dict(orders.references)) == ("waiting", "by hand", {})
    assert max(math.dist(held[name][:2], robot.pose[:2]) for name, robot in bed.robots.items()) < 0.01
    bed.stopped = ""
    arrives(bed)


@pytest.mark.slow
def test_somebody_who_walks_through_is_waited_for() -> None:
    bed = bed_in(bare())
    bed.run(12.0)
    x_m = float(bed.robots["r1"].pose.apply([0.45, 0.0])[0])
    for y_m in np.arange(0.9, 2.6, 0.02):
        person_m = np.array([x_m, y_m])
        bed.moving = [person_m + np.array([[-0.1, -0.1], [0.1, -0.1], [0.1, 0.1], [-0.1, 0.1]])]
        bed.step()
        for robot in bed.robots.values():
            assert math.dist(robot.pose[:2], person_m) > 0.25 or robot.speed_m_s < 0.03, "nobody drives into somebody"
    bed.moving = []
    arrives(bed)


@pytest.mark.slow
def test_a_robot_that_is_held_up_is_not_left_behind() -> None:
    bed = bed_in(bare())
    bed.run(12.0)
    held = bed.robots["r2"].pose
    for _ in range(60):
        bed.robots["r2"] = Unicycle(held)
        bed.step()
    assert bed.records[-1].orders.reason.startswith("waiting for r2")
    assert math.dist(bed.robots["r1"].pose[:2], held[:2]) < 0.8
    arrives(bed)


def test_nobody_moves_before_all_have_come() -> None:
    bed = bed_in(bare())
    bed.present.discard("r3")
    orders = bed.run(2.0)
    assert (orders.phase, orders.reason) == ("waiting", "waiting for r3")
    bed.present.add("r3")
    arrives(bed)


@pytest.mark.slow
def test_goals_are_driven_to_one_after_the_other() -> None:
    arena = bare()
    task = Task(shape=WEDGE, leader="r1", goals=((2.2, 1.5), (2.8, 2.2)), bounds=BOUNDS)
    bed = Bed(arena, task, loose_wedge(arena, task, 3, np.random.default_rng(0)))
    arrives(bed)
    path = [record.poses["r1"][:2] for record in bed.records]
    assert min(math.dist(place, (2.2, 1.5)) for place in path) < 0.05
    assert math.dist(path[-1], (2.8, 2.2)) < 0.05


@pytest.mark.slow
def test_the_same_world_gives_the_same_orders() -> None:
    def run() -> list[Orders]:
        bed = bed_in(gate(0.4))
        bed.run(20.0)
        return [record.orders for record in bed.records]

    assert run() == run()


def test_a_goal_that_cannot_be_reached_is_told() -> None:
    bed = bed_in(gate(0.1))
    bed.knows_all = True
    orders = bed.run(5.0, until=lambda orders: orders.phase == "blocked")
    assert (orders.phase, orders.reason) == ("blocked", "no way to (3.60, 1.50)")


@pytest.mark.slow
@pytest.mark.timeout(600)
@pytest.mark.parametrize("seed", range(20))
def test_a_random_arena_with_a_narrow_gap_is_crossed(seed: int) -> None:
    bed = bed_in(random_arena(seed), seed=seed)
    arrives(bed, 180.0)
    assert rms_m(bed.records, "moving") < 0.02
    assert rms_m(bed.records, "avoiding") < 0.02
