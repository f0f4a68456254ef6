"""The helm's loop, between a wheel guard and an agent that do as the test says, on a real bus."""

from __future__ import annotations

import socket
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np
import pytest

from agent.clocks.clock_map import ClockMap
from agent.clocks.local_clock import LocalClock
from agent.drivers.wheels import WheelCondition
from agent.driving.guard import HEARTBEAT_LIMIT_S
from agent.driving.guard_pipe import DriveOrder, Latch, LatchOrder
from agent.driving.helm_pipe import HelmReport, Look
from agent.driving.pipe import Pipe
from agent.driving.steering import Steering
from protocol.bus import Bus
from protocol.fields import Packed, pose_tuple
from protocol.geometry import Pose2
from protocol.messages import ClockReading, Poses, RobotPose, WheelReadings, WorldTime
from protocol.topics import POSES, SERVER_CLOCK, SETPOINTS, WORLD_TIME
from tests.unit.agent.control.broadcasts import MS, broadcast
from tests.unit.agent.control.local_maps import local_map
from tests.unit.agent.robot_config import CONFIG

PATIENCE_S = 10.0
HELD = Latch(stopped=True, reason="a cat", orders=1)


@dataclass
class FakeGuard:
    """Has readings to take, and notes what it is told."""

    readings: list[WheelReadings] = field(default_factory=list)
    refused: Mapping[str, int] = field(default_factory=dict)
    latch: Latch = field(default_factory=lambda: Latch(stopped=False, reason="", orders=0))
    condition: WheelCondition = field(default_factory=WheelCondition)
    beats: int = 0
    orders: list[DriveOrder] = field(default_factory=list)

    def instruct(self, drive: DriveOrder | None = None, latch: LatchOrder | None = None) -> None:
        self.beats += 1
        self.orders += [] if drive is None else [drive]

    def stamp_by(self, clock_map: ClockMap | None) -> None: ...

    def take(self) -> list[WheelReadings]:
        taken, self.readings = self.readings, []
        return taken


@dataclass
class Helm:
    """Steering, and all that is around it, on a clock that moves by every wait."""

    server: Bus
    robot: Bus
    pipe: Pipe
    agent: Pipe
    guard: FakeGuard = field(default_factory=FakeGuard)
    now_s: float = 100.0

    def __post_init__(self) -> None:
        self.steering = Steering(CONFIG, self.robot, self.guard, self.pipe, LocalClock(), lambda: self.now_s)

    def learn_clock(self, stamp_ms: int) -> None:
        """Have the swarm's clock asked for, and answer."""
        questions, answered = self.server.queries(SERVER_CLOCK), self.robot.inbox(WORLD_TIME)
        self.steering.turn()
        while not (asked := questions.take()):
            assert self.server.wait(PATIENCE_S)
        asked[0].reply(ClockReading(stamp_ns=stamp_ms * MS, runs="world"))
        self.server.publisher(WORLD_TIME).put(WorldTime(stamp_ns=stamp_ms * MS, robots=("r1",)))
        while not answered.take():
            assert self.robot.wait(PATIENCE_S)

    def hear(self, stamp_ms: int) -> None:
        """Have the swarm say where the robot is, and that it should go on from there."""
        pose = RobotPose(robot="r1", arena_from_body=pose_tuple(Pose2.identity()), covariance=(0.0,) * 6, predicted=False)
        self.server.publisher(POSES).put(Poses(seq=0, stamp_ns=stamp_ms * MS, robots=(pose,)))
        self.server.publisher(SETPOINTS).put(broadcast(stamp_ms, 0, pose=(0.05, 0.0, 0.0), speed_m_s=0.15))


@pytest.fixture
def helm() -> Iterator[Helm]:
    ours, theirs = socket.socketpair()
    with ours, theirs, Bus.open_router("home") as server, Bus.open_client("home", server.endpoint) as robot:
        yield Helm(server, robot, Pipe(ours), Pipe(theirs))


def readings(stamp_ms: int) -> WheelReadings:
    """Return one reading of wheels that stand."""
    return WheelReadings(until_ns=stamp_ms * MS, stamps_ns=Packed.of([stamp_ms * MS], "i8"), angles_rad=Packed.of(np.zeros((1, 2)), "f8"))


def test_a_picture_that_was_seen_before_its_setpoints_were_sent_counts_for_them(helm: Helm) -> None:
    helm.learn_clock(100)
    helm.guard.readings = [readings(100)]
    helm.agent.send(Look(local_map=local_map(100), angles_rad=(0.0, 0.0)))
    helm.hear(100)
    while not helm.guard.orders:
        helm.steering.turn()
    assert helm.guard.orders[0].answers_ns == 100 * MS
    assert helm.guard.orders[0].left_rad_s > 0.0


def test_wheels_that_are_lost_are_why_the_robot_stands(helm: Helm) -> None:
    helm.guard.condition = WheelCondition(trouble="wheels: /dev/ttyUSB0 is gone; trying again", battery=0.4)
    helm.steering.turn()
    [report] = helm.agent.take(HelmReport)
    assert (report.drive, report.why, report.wheels) == ("standing", helm.guard.condition.trouble, helm.guard.condition)


def test_guard_hears_that_the_loop_turns_while_nothing_comes(helm: Helm) -> None:
    def wait(timeout_s: float) -> None:
        helm.now_s += timeout_s

    helm.steering.run(lambda: helm.now_s >= 102.0, wait)
    assert helm.guard.beats >= 2 * 2.0 / HEARTBEAT_LIMIT_S


def test_the_agent_gets_all_readings_in_their_order(helm: Helm) -> None:
    helm.guard.readings = [readings(20), readings(40)]
    helm.steering.turn()
    helm.guard.readings = [readings(60)]
    helm.steering.turn()
    assert [report.readings for report in helm.agent.take(HelmReport)] == [readings(20), readings(40), readings(60)]


def test_the_agent_hears_once_how_the_robot_fares(helm: Helm) -> None:
    helm.steering.turn()
    helm.steering.turn()
    helm.guard.latch = HELD
    helm.steering.turn()
    helm.steering.turn()
    assert [(report.drive, report.why) for report in helm.agent.take(HelmReport)] == [("standing", ""), ("stopped", "stopped: a cat")]


def test_the_agent_hears_what_guard_and_swarm_sent_in_vain(helm: Helm) -> None:
    helm.guard.refused = {"malformed": 2}
    helm.steering.turn()
    [report] = helm.agent.take(HelmReport)
    assert report.refused == {"malformed": 2}


def test_the_loop_ends_when_the_agent_is_gone(helm: Helm) -> None:
    helm.agent.close()
    helm.steering.run(lambda: False, lambda _: None)
    assert helm.pipe.ended
