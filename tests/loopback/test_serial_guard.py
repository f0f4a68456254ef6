"""A wheel guard in its own process, on a serial line."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import pytest

from agent.clocks.clock_map import ClockMap
from agent.clocks.local_clock import LocalClock
from agent.driving.guard_pipe import DriveOrder
from agent.driving.guard_process import GuardProcess
from protocol.messages import WheelReadings
from tests.serial_robot import write_serial_robot
from tests.unit.agent.drivers.port import Board, Port

LIMIT_S = 20.0
FORWARD = DriveOrder(left_rad_s=1.0, right_rad_s=1.0, valid_s=0.45, answers_ns=7)


@dataclass
class Robot:
    """A guard, a helm that says the same in every turn, and a board."""

    guard: GuardProcess
    port: Port
    board: Board
    readings: list[WheelReadings] = field(default_factory=list)

    def until(self, is_so: Callable[[], bool], order: DriveOrder | None = None) -> float:
        """Turn helm and board until something is so, and return how long that took [s]."""
        start_s = time.monotonic()
        while not is_so():
            assert time.monotonic() - start_s < LIMIT_S, self.guard.condition
            now_ns = time.monotonic_ns()
            self.guard.stamp_by(ClockMap(local_ns=now_ns, server_ns=now_ns, rate=1.0, sigma_s=0.0))
            self.guard.instruct(order)
            self.readings += self.guard.take()
            if heard := self.port.heard():
                self.port.say(self.board.reply(heard))
            time.sleep(0.002)  # the pace of a board
        return time.monotonic() - start_s

    def until_readings(self, order: DriveOrder | None = None) -> None:
        wanted = len(self.readings) + 3
        self.until(lambda: len(self.readings) >= wanted, order)


@pytest.fixture
def robot(tmp_path: Path) -> Iterator[Robot]:
    port = Port(tmp_path)
    config_file = write_serial_robot(tmp_path, "ros_arduino_bridge", port.path, "settle_s = 0.0")
    with GuardProcess.start(config_file, LocalClock()) as guard:
        yield Robot(guard, port, Board())
    port.pull()


def test_a_guard_waits_for_its_wheels_and_outlives_a_pulled_line(robot: Robot) -> None:
    robot.guard.wait_ready(lambda: False)
    assert robot.guard.condition.trouble
    robot.port.plug_in()
    robot.until_readings()
    robot.until(lambda: robot.board.speeds == (10, 10), FORWARD)
    robot.port.pull()
    assert robot.until(lambda: "is gone; trying again" in robot.guard.condition.trouble, FORWARD) < 1.0
    until_ns = robot.readings[-1].until_ns
    robot.board.speeds = (0, 0)  # as the firmware itself does after 2 s
    robot.port.plug_in()
    robot.until_readings(FORWARD)
    assert robot.guard.condition.trouble == ""
    assert robot.readings[-1].until_ns > until_ns
    robot.until(lambda: robot.board.speeds == (10, 10), FORWARD)


def test_wheels_stand_when_the_helm_falls_silent(robot: Robot) -> None:
    robot.port.plug_in()
    robot.until_readings()
    robot.until(lambda: robot.board.speeds == (10, 10), FORWARD)
    start_s = time.monotonic()
    while robot.board.speeds != (0, 0):
        assert time.monotonic() - start_s < LIMIT_S
        robot.port.say(robot.board.reply(robot.port.heard()))


def test_a_guard_that_ends_has_the_wheels_stand(robot: Robot) -> None:
    robot.port.plug_in()
    robot.until_readings()
    robot.until(lambda: robot.board.speeds == (10, 10), FORWARD)
    robot.guard.close()
    while robot.board.speeds != (0, 0):
        robot.board.reply(robot.port.heard(at_least=1))
    assert robot.board.speeds == (0, 0)
