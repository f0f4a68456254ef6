"""What cameras are asked for, and what goes wrong with them."""

from __future__ import annotations

from typing import Literal

import pytest

from sim.world.bodies import CARRIED_M
from sim.world.cameras import DARK_LEVELS, CameraFault, Cameras
from sim.world.world import Moment
from tests.unit.sim.world.stages import PERIOD_NS, TinyEye, world

START_NS = 1_700_000_000_000_000_000


def moments(count: int) -> list[Moment]:
    turning = world((0.0, 0.0, 0.0), (1.0, 0.0, 0.0))
    return [turning.step() for _ in range(count)]


def fault(kind: Literal["camera_freezes", "camera_dark", "camera_silent"]) -> CameraFault:
    """Return a fault of r1 in the second and third of the moments."""
    return CameraFault("r1", kind, START_NS + 2 * PERIOD_NS, START_NS + 4 * PERIOD_NS)


def levels(kind: Literal["camera_freezes", "camera_dark"], robot: str = "r1") -> list[int]:
    """Return the brightest value of four pictures, where the eye would show 11, 12, 13, 14."""
    cameras = Cameras({"r1": TinyEye(), "r2": TinyEye()}, seed=1, faults=[fault(kind)])
    return [int(cameras.picture(robot, moment).max()) for moment in moments(4)]


def test_a_camera_sees_the_others_but_not_itself() -> None:
    eye = TinyEye()
    [moment] = moments(1)
    Cameras({"r1": TinyEye(), "r2": eye}, seed=1).picture("r2", moment)
    assert eye.seen == [(moment.robots[1].arena_from_body, ["r1"], 0)]


def test_a_robot_that_is_carried_looks_from_above_and_is_not_seen() -> None:
    lift = {"robot": "r2", "kind": "lifted", "from_s": 0.0, "until_s": 1.0, "to": (2.0, 0.0, 0.0)}
    turning = world((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), faults=[lift])
    turning.step()
    eyes = {"r1": TinyEye(), "r2": TinyEye()}
    for robot in eyes:
        Cameras(eyes, seed=1).picture(robot, turning.step())
    assert eyes["r1"].heights_m == [0.0]
    assert eyes["r1"].seen[0][1] == []
    assert eyes["r2"].heights_m == [CARRIED_M]


def test_a_frozen_camera_shows_its_last_picture() -> None:
    first, second, third, fourth = levels("camera_freezes")
    assert (second, third) == (first, first)
    assert fourth > first


def test_a_dark_camera_shows_noise() -> None:
    first, second, third, fourth = levels("camera_dark")
    assert second < DARK_LEVELS
    assert third < DARK_LEVELS
    assert fourth > first >= DARK_LEVELS


@pytest.mark.parametrize("kind", ["camera_freezes", "camera_dark"])
def test_a_fault_befalls_one_robot_only(kind: Literal["camera_freezes", "camera_dark"]) -> None:
    assert levels(kind, "r2") == [11, 12, 13, 14]


def test_a_silent_camera_does_not_fire() -> None:
    cameras = Cameras({"r1": TinyEye(), "r2": TinyEye()}, seed=1, faults=[fault("camera_silent")])
    assert [cameras.fired(moment.stamp_ns) for moment in moments(4)] == [("r1", "r2"), ("r2",), ("r2",), ("r1", "r2")]
