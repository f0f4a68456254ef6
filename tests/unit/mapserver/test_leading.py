"""From batches to broadcasts: who is present, what goes out, what an order to stop does, and what the clock says."""

from __future__ import annotations

import math

import numpy as np
import pytest

from mapserver.batching import Batch
from mapserver.export import grid_picture
from mapserver.formation.controller import FormationController, Orders
from mapserver.formation.shapes import Shape
from mapserver.formation.task import Task
from mapserver.formation.trail import Reference
from mapserver.leading import VALIDITY_NS, Lead, said
from mapserver.mapping.bodies import Body
from mapserver.mapping.things.movers import MoverWatch
from mapserver.pipeline import MapPipeline
from mapserver.servertime import ServerTime
from mapserver.stopping import StopLatch
from protocol.geometry import Pose2
from protocol.messages import FREE, LocalMap
from protocol.stage_clock import StageClock
from tests.unit.mapserver.worlds import STEP_NS, batch, local_map, rectangle, region_of, settings

STARTS = {"r1": Pose2(0.0, 0.0, 0.0), "r2": Pose2(-0.4, 0.0, 0.0)}
HERE = frozenset(STARTS)


class Swarm:
    """Two robots that stand in a column, and the map server's insides."""

    def __init__(self) -> None:
        self.pipeline = MapPipeline([settings(robot, pose) for robot, pose in STARTS.items()], StageClock())
        task = Task(shape=Shape("column", 0.4), leader="r1", goals=((1.5, 0.0),))
        self.lead = Lead(FormationController(task, dict.fromkeys(STARTS, 0.075)))
        self._seq = 0

    def step(self, *robots: str, present: frozenset[str] = HERE, stopped: str = "") -> Orders:
        stamp_ns = (self._seq + 1) * STEP_NS
        merged = self.pipeline.step(Batch(stamp_ns, tuple(local_map(robot, self._seq) for robot in robots)))
        self._seq += 1
        return self.lead.step(merged.poses, self.pipeline, present, stopped)


def test_robots_that_are_heard_get_setpoints() -> None:
    assert set(Swarm().step("r1", "r2").references) == HERE


def test_a_robot_without_its_token_gets_none() -> None:
    swarm = Swarm()
    swarm.step("r1", "r2")
    assert set(swarm.step("r1", "r2", present=frozenset(["r1"])).references) == {"r1"}


def test_a_robot_that_is_silent_for_more_than_a_second_gets_none() -> None:
    swarm = Swarm()
    swarm.step("r1", "r2")
    told = [set(swarm.step("r1").references) for _ in range(7)]
    assert told[:5] == [HERE] * 5
    assert told[5:] == [{"r1"}] * 2


def test_while_the_swarm_is_held_nobody_gets_any() -> None:
    swarm = Swarm()
    swarm.step("r1", "r2")
    orders = swarm.step("r1", "r2", stopped="by hand")
    assert (dict(orders.references), orders.phase, orders.reason) == ({}, "waiting", "by hand")


def test_without_a_formation_nobody_is_moved() -> None:
    swarm = Swarm()
    merged = swarm.pipeline.step(batch([local_map("r1", 0)]))
    assert dict(Lead(None).step(merged.poses, swarm.pipeline, HERE, "").references) == {}


def test_orders_become_messages_with_a_validity() -> None:
    orders = Orders({"r1": Reference(Pose2(1.0, 2.0, 0.5), 0.1, 0.2)}, "moving", leader="r1", goal=(3.0, 0.0), slots={"r1": (0.0, 0.0)})
    setpoints, state = said(orders, epoch=7, seq=3, stamp_ns=10**9)
    assert (setpoints.epoch, setpoints.seq, setpoints.valid_until_ns) == (7, 3, 10**9 + VALIDITY_NS)
    assert setpoints.robots[0].arena_from_body == (1.0, 2.0, 0.5)
    assert (state.phase, state.leader, state.goal, state.seq) == ("moving", "r1", (3.0, 0.0), 3)


def test_a_stop_holds_until_it_is_released() -> None:
    latch = StopLatch()
    assert latch.obey({"order": "stop", "reason": "fire"}).stopped
    assert latch.obey({"order": "go"}).reason == "fire"
    assert latch.obey({"order": "stop"}).reason == "stopped by order"
    assert not latch.obey({"order": "release"}).stopped


def test_in_a_world_every_stamp_is_a_step_and_on_the_wall_clock_every_tenth_of_a_second() -> None:
    world, wall = ServerTime("world", lambda: 99), ServerTime("wall", lambda: 99)
    due = {"world": 0, "wall": 0}
    for stamp_ns in range(0, 1_000_000_000, 20_000_000):
        for name, clock in (("world", world), ("wall", wall)):
            clock.reached(stamp_ns)
            due[name] += clock.is_step_due()
    assert due == {"world": 50, "wall": 10}
    assert (world.reading().stamp_ns, wall.reading().stamp_ns) == (980_000_000, 99)


def test_the_floor_is_one_array_that_agrees_with_the_tiles() -> None:
    swarm = Swarm()
    swarm.step("r1", "r2")
    floor = swarm.pipeline.floor()
    picture = grid_picture(swarm.pipeline.snapshot())
    assert np.array_equal(floor.cells == FREE, picture.pixels[::-1] == 254)
    assert floor.origin_m.tolist() == list(picture.origin_m)
    row, column = np.floor((np.array([0.3, 0.3]) - floor.origin_m) / floor.cell_m).astype(int)[::-1]
    assert floor.cells[row, column] == FREE


def walker(seq: int, x_m: float, motion: str = "moving") -> LocalMap:
    region = region_of(rectangle(x_m, 0.0, 0.2, 0.2), STARTS["r1"], motion)  # type: ignore[arg-type]
    return local_map("r1", seq, regions=[region])


def test_what_is_seen_to_move_again_and_again_is_kept_away_from() -> None:
    watch = MoverWatch()
    for seq in range(4):
        watch.observe(walker(seq, 0.8 + 0.05 * seq), STARTS["r1"], [])
        assert len(watch.footprints((seq + 1) * STEP_NS)) == (seq >= 2)
    (footprint_m,) = watch.footprints(4 * STEP_NS)
    assert footprint_m.mean(axis=0) == pytest.approx([0.95, 0.0])
    assert watch.footprints(4 * STEP_NS + 2_000_000_000) == []


def test_robots_and_what_stands_are_no_movers() -> None:
    watch = MoverWatch()
    robot = Body(np.array([0.8, 0.0]), 0.075, 0.0)
    for seq in range(4):
        watch.observe(walker(seq, 0.8), STARTS["r1"], [robot])
        watch.observe(walker(seq, 1.4, "static"), STARTS["r1"], [])
    assert watch.footprints(4 * STEP_NS) == []


def test_a_lost_robot_is_driven_around() -> None:
    swarm = Swarm()
    for _ in range(3):
        swarm.step("r1", "r2")
    orders = swarm.step("r1", "r2", present=frozenset(["r2"]))
    for _ in range(10):
        orders = swarm.step("r1", "r2", present=frozenset(["r2"]))
    assert set(orders.references) <= {"r2"}
    assert all(math.dist(each.arena_from_body[:2], STARTS["r1"][:2]) > 0.15 for each in orders.references.values())
