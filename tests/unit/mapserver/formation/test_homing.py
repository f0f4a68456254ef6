"""A robot whose battery is low leaves the formation, goes home, and parks; the others go on."""

from __future__ import annotations

import math

import numpy as np
import pytest

from mapserver.formation.shapes import Shape
from mapserver.formation.task import Task
from protocol.geometry import Pose2
from tests.unit.mapserver.formation.arenas import BOUNDS, Arena
from tests.unit.mapserver.formation.bed import RADIUS_M, Bed, loose_wedge

ARENA = Arena((), Pose2(0.8, 1.5, 0.0), (2.2, 1.5), 0.0)
TASK = Task(shape=Shape("wedge", distance_m=0.45, angle_rad=0.6), leader="r1", goals=(ARENA.goal_m,), bounds=BOUNDS)


def under_way(low: str) -> tuple[Bed, Pose2]:
    """Return a wedge in mid drive in which one robot's battery has become low, and where that robot began."""
    bed = Bed(ARENA, TASK, loose_wedge(ARENA, TASK, 3, np.random.default_rng(0)), knows_all=True)
    home = bed.robots[low].pose
    bed.run(60.0, until=lambda orders: bed.robots["r1"].pose.x_m > 1.3)
    bed.low = frozenset({low})
    return bed, home


def is_home(bed: Bed, robot: str, home: Pose2) -> bool:
    return math.dist(bed.robots[robot].pose[:2], home[:2]) < 0.08


def test_follower_goes_home_and_gets_no_setpoint_there_while_the_others_arrive() -> None:
    bed, home = under_way("r2")
    assert bed.step().reason == "r2 goes home: battery low"
    bed.run(120.0, until=lambda orders: orders.phase == "arrived" and "parked" in orders.reason)
    assert is_home(bed, "r2", home)
    assert set(bed.step().references) == {"r1", "r3"}
    assert math.dist(bed.robots["r1"].pose[:2], ARENA.goal_m) < 0.08
    assert bed.collisions == []
    assert bed.closest_m > 2.0 * RADIUS_M


@pytest.mark.slow
def test_leader_goes_home_as_well_and_another_leads() -> None:
    bed, home = under_way("r1")
    bed.run(120.0, until=lambda orders: orders.phase == "arrived" and "parked" in orders.reason)
    assert is_home(bed, "r1", home)
    assert bed.step().leader in {"r2", "r3"}
    assert bed.collisions == []


@pytest.mark.slow
def test_charged_robot_falls_in_again() -> None:
    bed, _ = under_way("r2")
    bed.run(3.0, until=lambda orders: False)
    bed.low = frozenset()
    orders = bed.run(120.0, until=lambda orders: orders.phase == "arrived")
    assert orders.phase == "arrived"
    assert set(orders.references) == {"r1", "r2", "r3"}
    assert bed.collisions == []


def test_held_swarm_holds_those_on_their_way_home_too() -> None:
    bed, _ = under_way("r2")
    bed.step()
    bed.stopped = "by hand"
    assert dict(bed.step().references) == {}
