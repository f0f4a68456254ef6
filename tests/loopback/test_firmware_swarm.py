"""A whole swarm on emulated motor controllers: two with the ROSArduinoBridge firmware, one Create 2.

A serial line is pulled under way, and two robots have clocks that are wrong, drift, and leap.
"""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from agent.clocks.local_clock import LocalClock
from deploy.settings_files import MAP_SERVER
from protocol.geometry import Pose2
from tests.firmware_swarm import FirmwareSwarm, running_firmware_swarm

BOARDS = {"r1": "ros_arduino_bridge", "r2": "ros_arduino_bridge", "r3": "create2"}
LEADER, PULLED = "r1", "r2"
START = Pose2(-1.2, 0.0, 0.0)  # of the leader
GOAL_M = (0.0, 0.0)
FORMATION = {"kind": "wedge", "distance_m": 0.4, "angle_rad": 0.61, "goals": [list(GOAL_M)], "bounds": [-2.0, -1.5, 2.0, 1.5]}
SCENARIO = """
name = "serial"
seed = 3
duration_s = 600.0

[arena]
floor = "paint"

[camera]
width_px = 320
height_px = 240
rate_hz = 3.0

[[boxes]]
centre_m = [0.6, 0.9]
size_m = [0.3, 0.2]
yaw_rad = 0.4
height_m = 0.15
material = "card"

[[cylinders]]
centre_m = [-0.2, -0.9]
radius_m = 0.12
height_m = 0.22
rgb = [110, 52, 128]

[[robots]]
name = "r1"
start = [-1.2, 0.0, 0.0]
rig = { encoder_ticks_per_rev = 1920 }

[[robots]]
name = "r2"
start = [-1.53, 0.23, 0.0]
rig = { encoder_ticks_per_rev = 1920 }

[[robots]]
name = "r3"
start = [-1.53, -0.23, 0.0]
"""

FIRMWARE_STOP_S = 2.0
FAR_ENOUGH_M = 0.4  # from its start: the swarm drives
SLOT_M = 0.06  # how far from its slot a follower may stay
PATH_M = 0.05  # how far from its true place a robot may believe itself


@pytest.fixture
def swarm(tmp_path: Path) -> Iterator[FirmwareSwarm]:
    scenario = tmp_path / "serial.toml"
    scenario.write_text(SCENARIO)
    with running_firmware_swarm(scenario, BOARDS, FORMATION, tmp_path, bad_clocks()) as swarm:
        yield swarm
    for log in (tmp_path / "logs").iterdir():
        assert "Traceback" not in log.read_text(), log


def bad_clocks() -> dict[str, LocalClock]:
    """Return clocks that are wrong and drift, one of which leaps while the swarm drives."""
    now_s = time.monotonic()
    return {
        "r2": LocalClock(offset_s=10.0, drift_ppm=100.0, since_s=now_s),
        "r3": LocalClock(offset_s=-10.0, drift_ppm=-100.0, step_s=1.0, step_at_s=20.0, since_s=now_s),
    }


@pytest.mark.slow
@pytest.mark.timeout(400)
def test_a_swarm_on_serial_lines_drives_in_formation_though_one_of_them_is_pulled(swarm: FirmwareSwarm) -> None:
    swarm.until(lambda: way_m(swarm) > FAR_ENOUGH_M and swarm.turns(PULLED), 120.0)

    stopped_s = pull_and_wait(swarm)
    assert stopped_s < FIRMWARE_STOP_S + 0.3
    stamp_ns, known = seen_ns(swarm), swarm.coverage.share
    swarm.until(lambda: "wheels" in swarm.statuses[PULLED].state and seen_ns(swarm) > stamp_ns + 10**9, 20.0)
    assert swarm.coverage.share >= known

    swarm.plug(PULLED)
    swarm.until(lambda: swarm.turns(PULLED), 30.0)
    freeze_map_server(swarm)
    swarm.until(lambda: phase(swarm) == "arrived", 120.0)
    swarm.until(lambda: worst_slot_m(swarm) < SLOT_M, 30.0)

    assert max(swarm.longest_s.values()) < 0.5, swarm.longest_s
    assert swarm.truth is not None
    assert [body.collisions for body in swarm.truth.bodies] == [0, 0, 0]
    assert swarm.coverage.share > 0.6
    truly = places(swarm)
    assert swarm.poses is not None
    for robot in swarm.poses.robots:
        assert distance_m(Pose2(*robot.arena_from_body), truly[robot.robot]) < PATH_M


def pull_and_wait(swarm: FirmwareSwarm) -> float:
    """Pull the line, and return how long the firmware lets the wheels turn on [s]."""
    pulled_s = swarm.unplug(PULLED)
    swarm.until(lambda: not swarm.turns(PULLED), 10.0)
    return swarm.wheels[PULLED][-1].arrived_s - pulled_s


def freeze_map_server(swarm: FirmwareSwarm) -> None:
    """Freeze the map server until all wheels stand, and let it go on."""
    server = swarm.processes.pids[MAP_SERVER]
    os.kill(server, signal.SIGSTOP)
    try:
        frozen_s = time.monotonic()
        swarm.until(lambda: not any(swarm.turns(robot) for robot in BOARDS), 5.0)
        assert time.monotonic() - frozen_s < 2.0
    finally:
        os.kill(server, signal.SIGCONT)


def places(swarm: FirmwareSwarm) -> dict[str, Pose2]:
    """Return where the robots truly are, as far as the world has told."""
    return {body.robot: Pose2(*body.arena_from_body) for body in swarm.truth.bodies} if swarm.truth is not None else {}


def worst_slot_m(swarm: FirmwareSwarm) -> float:
    """Return how far the worst follower truly is from its slot behind the leader."""
    truly = places(swarm)
    if swarm.formation is None or not truly:
        return np.inf
    leader = truly[swarm.formation.leader]
    return max(distance_m(leader @ Pose2(*slot.leader_from_slot, 0.0), truly[slot.robot]) for slot in swarm.formation.slots)


def way_m(swarm: FirmwareSwarm) -> float:
    """Return how far the leader has come."""
    return distance_m(places(swarm).get(LEADER, START), START)


def seen_ns(swarm: FirmwareSwarm) -> int:
    """Return the stamp of the newest poses."""
    return swarm.poses.stamp_ns if swarm.poses is not None else 0


def phase(swarm: FirmwareSwarm) -> str:
    """Return what the formation is doing."""
    return swarm.formation.phase if swarm.formation is not None else ""


def distance_m(one: Pose2, other: Pose2) -> float:
    """Return how far apart two places are."""
    return float(np.hypot(one.x_m - other.x_m, one.y_m - other.y_m))
