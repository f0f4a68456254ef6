"""Where a robot cannot follow its reference, something is taken to stand, unless the map or another robot says what it is."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
import pytest

from mapserver.formation.bumps import LASTS_NS, Bumps
from mapserver.formation.costmap import CostMap, Disc, cost_map
from mapserver.formation.floor import Bounds, Floor
from mapserver.formation.task import Moment
from mapserver.formation.trail import Reference
from protocol.geometry import Pose2
from protocol.messages import FREE

RADIUS_M = 0.075
FLOOR = Floor(np.full((300, 400), FREE, np.uint8), np.zeros(2), 0.01)
OPEN = cost_map(FLOOR, Bounds(0.0, 0.0, 4.0, 3.0), np.array([[2.0, 1.5]]), [])
HELD = Pose2(1.0, 1.0, 0.0)
STEP_NS = 100_000_000


@dataclass
class Watched:
    """A robot that is at the same place for a while, and what is made of that."""

    scene: CostMap = OPEN
    others: dict[str, Pose2] = field(default_factory=dict)
    reference: Pose2 = field(default=Pose2(1.1, 1.0, 0.0))

    def __post_init__(self) -> None:
        self.bumps, self.stamp_ns = Bumps(RADIUS_M), 0

    def stays(self, seconds: float, speed_m_s: float = 0.0) -> list[Disc]:
        for step in range(round(seconds * 1e9) // STEP_NS):
            pose = Pose2(HELD.x_m + speed_m_s * step * 1e-9 * STEP_NS, HELD.y_m, 0.0)
            moment = Moment(self.stamp_ns, {"r1": pose, **self.others}, {}, FLOOR)
            self.bumps.note(moment, {"r1": Reference(self.reference, 0.1, 0.0)}, self.scene)
            self.stamp_ns += STEP_NS
        return list(self.bumps.things())


def test_a_robot_that_is_held_up_has_come_up_against_one_thing_just_ahead() -> None:
    (thing,) = Watched().stays(6.0)
    gap_m = math.dist(thing.centre_m, HELD[:2]) - RADIUS_M - thing.radius_m
    assert thing.centre_m[0] > HELD.x_m
    assert 0.01 < gap_m < 0.03


def test_it_is_forgotten_after_a_while() -> None:
    watched = Watched()
    watched.stays(6.0)
    watched.reference = HELD
    assert len(watched.stays(1e-9 * LASTS_NS - 1.0)) == 1
    assert watched.stays(2.0) == []


@pytest.mark.parametrize(
    "watched",
    [
        pytest.param(Watched(reference=Pose2(1.02, 1.0, 0.0)), id="it stands where it is to stand"),
        pytest.param(Watched(others={"r2": Pose2(1.2, 1.0, 0.0)}), id="another robot is in its way"),
        pytest.param(Watched(scene=OPEN.with_discs([Disc(np.array([1.16, 1.0]), 0.05)])), id="the map shows what is in its way"),
    ],
)
def test_where_that_is_explained_nothing_is_made_up(watched: Watched) -> None:
    assert watched.stays(6.0) == []


def test_a_robot_that_is_held_up_for_a_moment_has_come_up_against_nothing() -> None:
    assert Watched().stays(3.0) == []


def test_the_times_that_it_is_held_up_at_one_place_add_up() -> None:
    watched = Watched()
    watched.stays(3.0)
    watched.reference = HELD
    watched.stays(3.0)
    watched.reference = Pose2(1.1, 1.0, 0.0)
    assert len(watched.stays(3.0)) == 1


def test_a_robot_that_moves_on_is_not_held_up() -> None:
    assert Watched().stays(6.0, speed_m_s=0.03) == []
