"""Setpoints of a real map server process: what goes out, how often, and how an order to stop takes them back."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import TypeVar

import pytest

from protocol.bus import Bus
from protocol.geometry import Pose2
from protocol.messages import FormationState, Setpoints, StopState, WorldTime
from protocol.topics import AGENT_ALIVE, FORMATION, LOCAL_MAP, SERVER_ALIVE, SERVER_CLOCK, SERVER_STOP, SETPOINTS, WORLD_TIME
from tests.unit.mapserver.worlds import STEP_NS, local_map

ROOT = Path(__file__).parents[2]
SITE = "lab"
DEADLINE_S = 20.0
STARTS = {"r1": Pose2(0.0, 0.0, 0.0), "r2": Pose2(-0.45, 0.0, 0.0)}
CONFIG = """
site = "lab"
clock = "world"
[[robots]]
name = "r1"
initial_pose = [0.0, 0.0, 0.0]
[[robots]]
name = "r2"
initial_pose = [-0.45, 0.0, 0.0]
[formation]
kind = "column"
goals = [[2.0, 0.0]]
"""

T = TypeVar("T")


class Swarm:
    """A map server that leads two robots, which report that they stand still."""

    def __init__(self, folder: Path, resources: ExitStack, config: str = CONFIG) -> None:
        file = folder / "mapserver.toml"
        file.write_text(config)
        command = [sys.executable, "-m", "mapserver", "--config", str(file)]
        self.server = resources.enter_context(
            subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        )
        resources.callback(self.server.kill)
        assert self.server.stdout is not None
        self.endpoint = self.server.stdout.readline().split()[1]
        self.bus = resources.enter_context(Bus.open_client(SITE, self.endpoint))
        self.bus.presence(SERVER_ALIVE).wait_for([SERVER_ALIVE.template], DEADLINE_S)
        self._setpoints, self._states = self.bus.inbox(SETPOINTS), self.bus.inbox(FORMATION)
        self._world = self.bus.publisher(WORLD_TIME)
        self._maps = {robot: self.bus.publisher(LOCAL_MAP, robot=robot) for robot in STARTS}
        for robot in STARTS:
            self.bus.announce(AGENT_ALIVE, robot=robot)
        self.bus.presence(AGENT_ALIVE).wait_for(STARTS, DEADLINE_S)

    def step(self, seq: int) -> Setpoints:
        """Let both robots report and the world go on, and return the first setpoints of that stamp."""
        for robot, publisher in self._maps.items():
            publisher.put(local_map(robot, seq))
        self._world.put(WorldTime(stamp_ns=(seq + 1) * STEP_NS, robots=tuple(STARTS)))
        return self.next(lambda each: each.stamp_ns == (seq + 1) * STEP_NS)

    def next(self, wanted: Callable[[Setpoints], bool]) -> Setpoints:
        return self._wait_for(lambda: next((each for each in self._setpoints.take() if wanted(each)), None))

    def state(self, wanted: Callable[[FormationState], bool]) -> FormationState:
        return self._wait_for(lambda: next((each for each in self._states.take() if wanted(each)), None))

    def order(self, **parameters: str) -> StopState:
        (state,) = self.bus.ask(SERVER_STOP, parameters=parameters)
        return state

    def end(self) -> None:
        self.server.send_signal(signal.SIGTERM)
        _, log = self.server.communicate(timeout=DEADLINE_S)
        assert self.server.returncode == 0, log

    def _wait_for(self, found: Callable[[], T | None]) -> T:
        deadline_s = time.monotonic() + DEADLINE_S
        while (result := found()) is None:
            assert time.monotonic() < deadline_s, "nothing came in time"
            self.bus.wait(0.1)
        return result


@pytest.fixture
def resources() -> Iterator[ExitStack]:
    with ExitStack() as stack:
        yield stack


def test_the_leader_sets_out_and_its_follower_keeps_its_distance(tmp_path: Path, resources: ExitStack) -> None:
    swarm = Swarm(tmp_path, resources)
    for seq in range(4):
        setpoints = swarm.step(seq)
    assert [each.robot for each in setpoints.robots] == ["r1", "r2"]
    leader, follower = setpoints.robots
    assert leader.speed_m_s > 0.0
    assert leader.arena_from_body[0] - follower.arena_from_body[0] == pytest.approx(0.45, abs=5e-3)
    assert setpoints.valid_until_ns == setpoints.stamp_ns + 500_000_000
    state = swarm.state(lambda each: each.stamp_ns == setpoints.stamp_ns)
    assert (state.phase, state.leader, state.goal) == ("moving", "r1", (2.0, 0.0))
    assert {slot.robot: slot.leader_from_slot[0] for slot in state.slots} == pytest.approx({"r1": 0.0, "r2": -0.45}, abs=1e-3)
    swarm.end()


def test_the_last_broadcast_is_repeated_with_its_own_stamp(tmp_path: Path, resources: ExitStack) -> None:
    swarm = Swarm(tmp_path, resources)
    first = swarm.step(0)
    again = [swarm.next(lambda each: True) for _ in range(3)]
    assert [each.seq for each in again] == [first.seq + 1, first.seq + 2, first.seq + 3]
    assert {(each.epoch, each.stamp_ns, each.valid_until_ns, each.robots) for each in again} == {
        (first.epoch, first.stamp_ns, first.valid_until_ns, first.robots)
    }
    swarm.end()


def test_an_order_to_stop_takes_all_setpoints_back_until_it_is_released(tmp_path: Path, resources: ExitStack) -> None:
    swarm = Swarm(tmp_path, resources)
    assert swarm.step(0).robots
    assert swarm.order(order="stop", reason="a hand in the arena") == StopState(who="server", stopped=True, reason="a hand in the arena")
    assert swarm.next(lambda each: not each.robots).stamp_ns == STEP_NS
    assert not swarm.step(1).robots
    assert swarm.state(lambda each: each.stamp_ns == 2 * STEP_NS).reason == "a hand in the arena"
    assert swarm.order().stopped
    assert not swarm.order(order="release").stopped
    assert swarm.step(2).robots
    swarm.end()


def test_the_clock_of_a_world_stands_at_its_last_stamp(tmp_path: Path, resources: ExitStack) -> None:
    swarm = Swarm(tmp_path, resources)
    swarm.step(0)
    (reading,) = swarm.bus.ask(SERVER_CLOCK)
    assert (reading.stamp_ns, reading.runs) == (STEP_NS, "world")
    swarm.end()


def test_a_restarted_server_has_a_higher_epoch(tmp_path: Path, resources: ExitStack) -> None:
    epochs = []
    for _ in range(2):
        swarm = Swarm(tmp_path, resources)
        epochs.append(swarm.step(0).epoch)
        swarm.end()
    assert epochs[0] < epochs[1]


def test_without_a_formation_nobody_is_moved(tmp_path: Path, resources: ExitStack) -> None:
    swarm = Swarm(tmp_path, resources, CONFIG[: CONFIG.index("[formation]")])
    assert swarm.step(0).robots == ()
    assert swarm.state(lambda each: True).reason == "no formation is asked for"
    swarm.end()
