"""When the wheel guard lets the wheels turn, and when it stops them. The wheels hold their last command for ever."""

from __future__ import annotations

import socket
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest

from agent.clocks.clock_map import ServerStamps
from agent.clocks.local_clock import LocalClock
from agent.control.twist import within_wheel_speed
from agent.drivers.wheels import WheelCondition
from agent.driving.guard import CYCLE_S, HEARTBEAT_LIMIT_S, Guard
from agent.driving.guard_pipe import DriveOrder, GuardReport, Instruction, LatchOrder
from agent.driving.latch_file import LatchFile
from agent.driving.pipe import Pipe
from protocol.errors import DecodeError, DriverError
from protocol.fields import Packed
from protocol.messages import WheelCommand, WheelReadings

STOP = WheelCommand(left_rad_s=0.0, right_rad_s=0.0)
MAX_WHEEL_RAD_S = 12.0


@dataclass
class FakeWheels:
    """Wheels on a clock of their own: every read takes the whole time that it may."""

    now_s: float = 100.0
    commands: list[WheelCommand] = field(default_factory=list)
    waiting: list[WheelReadings] = field(default_factory=list)
    refused: Mapping[str, int] = field(default_factory=dict)
    condition: WheelCondition = field(default_factory=WheelCondition)
    stops_by_itself_s: float | None = None
    during_read: Callable[[], None] = lambda: None

    @property
    def turning(self) -> bool:
        return bool(self.commands) and (self.commands[-1].left_rad_s, self.commands[-1].right_rad_s) != (0.0, 0.0)

    @property
    def stops(self) -> int:
        return self.commands.count(STOP)

    def read(self, timeout_s: float) -> Sequence[WheelReadings]:
        self.now_s += timeout_s
        self.during_read()
        taken, self.waiting = self.waiting, []
        return taken

    def drive(self, left_rad_s: float, right_rad_s: float, answers_ns: int = 0) -> WheelCommand:
        left_rad_s, right_rad_s = within_wheel_speed(left_rad_s, right_rad_s, MAX_WHEEL_RAD_S)
        self.commands.append(WheelCommand(left_rad_s=left_rad_s, right_rad_s=right_rad_s, answers_ns=answers_ns))
        return self.commands[-1]

    def stop(self) -> None:
        self.drive(0.0, 0.0)

    def close(self) -> None: ...


@dataclass
class Robot:
    """A guard between such wheels and an agent that says what the test wants."""

    wheels: FakeWheels
    agent: Pipe
    pipe: Pipe
    guard: Guard
    said: int = 0

    def say(self, drive: DriveOrder | None = None, latch: LatchOrder | None = None) -> None:
        self.agent.send(Instruction(count=self.said, sent_s=self.wheels.now_s, drive=drive, latch=latch))
        self.said += 1

    def cycles_until_stopped(self, *, beating: bool) -> float:
        """Return how long [s] the wheels go on turning while the agent beats, or does not."""
        start_s = self.wheels.now_s
        while self.wheels.turning:
            if beating:
                self.say()
            self.guard.cycle()
        return self.wheels.now_s - start_s


@pytest.fixture
def robot() -> Iterator[Robot]:
    agent, guard = socket.socketpair()
    with agent, guard:
        wheels, pipe = FakeWheels(), Pipe(guard)
        yield Robot(wheels, Pipe(agent), pipe, Guard(wheels, pipe, ServerStamps(LocalClock()), lambda: wheels.now_s))


def order(left_rad_s: float = 3.0, right_rad_s: float = 4.0, valid_s: float = 0.45, answers_ns: int = 7) -> DriveOrder:
    return DriveOrder(left_rad_s=left_rad_s, right_rad_s=right_rad_s, valid_s=valid_s, answers_ns=answers_ns)


def stop(reason: str = "a cat") -> LatchOrder:
    return LatchOrder(order="stop", reason=reason)


def release() -> LatchOrder:
    return LatchOrder(order="release", reason="")


def never() -> bool:
    return False


def test_cycle_lasts_20_ms_at_most() -> None:
    assert CYCLE_S == 0.02


def test_wheels_are_stopped_once_when_the_heartbeat_is_too_old(robot: Robot) -> None:
    last_s = robot.wheels.now_s
    robot.say()
    robot.guard.cycle()
    while robot.wheels.stops == 0:
        robot.guard.cycle()
    assert HEARTBEAT_LIMIT_S < robot.wheels.now_s - last_s <= HEARTBEAT_LIMIT_S + 2 * CYCLE_S
    for _ in range(100):
        robot.guard.cycle()
    assert robot.wheels.stops == 1


def test_heartbeats_keep_the_wheels_from_being_stopped_and_their_end_stops_them_again(robot: Robot) -> None:
    for silence in range(2):
        for _ in range(50):
            robot.say()
            robot.guard.cycle()
        assert robot.wheels.stops == silence
        for _ in range(20):
            robot.guard.cycle()
        assert robot.wheels.stops == silence + 1


def test_an_order_is_carried_out_and_what_was_applied_is_reported_with_the_next_readings(robot: Robot) -> None:
    robot.say(order(left_rad_s=12.0, right_rad_s=24.0))
    robot.guard.cycle()
    half = WheelCommand(left_rad_s=6.0, right_rad_s=12.0, answers_ns=7)
    assert robot.wheels.commands == [half]
    robot.wheels.waiting = [WheelReadings(until_ns=9, stamps_ns=Packed.of([9], "i8"), angles_rad=Packed.of(np.zeros((1, 2)), "f8"))]
    robot.guard.cycle()
    assert [report.applied for report in robot.agent.take(GuardReport)] == [half]


def test_wheels_stop_when_no_order_follows_although_the_agent_still_beats(robot: Robot) -> None:
    robot.say(order(valid_s=0.45))
    robot.guard.cycle()
    assert 0.45 - CYCLE_S <= robot.cycles_until_stopped(beating=True) + 1e-9 <= 0.45 + CYCLE_S
    assert robot.agent.take(GuardReport)[-1].applied == STOP


def test_an_order_that_has_waited_too_long_in_the_pipe_turns_no_wheel(robot: Robot) -> None:
    robot.say(order(valid_s=0.45))
    robot.wheels.now_s += 0.5
    robot.guard.cycle()
    assert not robot.wheels.turning


def test_a_hazard_and_an_order_to_stop_are_both_told(robot: Robot) -> None:
    robot.wheels.condition = WheelCondition(hazard="wheel-drop left")
    robot.guard.cycle()
    robot.say(latch=LatchOrder(order="stop", reason="a cat"))
    robot.guard.cycle()
    assert robot.agent.take(GuardReport)[-1].latch.reason == "wheel-drop left; a cat"


def test_wheels_stop_when_the_agent_stands_still_in_mid_drive(robot: Robot) -> None:
    robot.say(order())
    robot.guard.cycle()
    assert robot.cycles_until_stopped(beating=False) <= HEARTBEAT_LIMIT_S + 2 * CYCLE_S


def test_wheels_turn_as_long_as_orders_come(robot: Robot) -> None:
    for number in range(50):
        robot.say(order(answers_ns=number))
        robot.guard.cycle()
        assert robot.wheels.turning
    assert [command.answers_ns for command in robot.wheels.commands] == list(range(50))


def test_a_latched_stop_holds_against_orders_and_each_is_answered_with_standing_wheels(robot: Robot) -> None:
    robot.say(order())
    robot.say(latch=stop())
    robot.say(order(answers_ns=8))
    robot.guard.cycle()
    assert robot.wheels.commands[1:] == [STOP, WheelCommand(left_rad_s=0.0, right_rad_s=0.0, answers_ns=8)]
    assert robot.agent.take(GuardReport)[-1].latch.model_dump() == {"stopped": True, "reason": "a cat", "orders": 1}


def test_a_latched_stop_outlasts_a_silence_of_the_agent(robot: Robot) -> None:
    robot.say(latch=stop())
    for _ in range(100):
        robot.guard.cycle()
    robot.say(order())
    robot.guard.cycle()
    assert not robot.wheels.turning


def test_only_a_release_ends_a_latched_stop_and_the_wheels_wait_for_a_new_order(robot: Robot) -> None:
    robot.say(latch=stop())
    robot.say(order())
    robot.say(latch=release())
    robot.guard.cycle()
    assert robot.wheels.commands[-1] == STOP
    robot.say(order())
    robot.guard.cycle()
    assert robot.wheels.turning
    assert robot.agent.take(GuardReport)[-1].latch.orders == 2


def test_a_bumper_stops_the_wheels_at_once_and_holds_them_when_it_is_free_again(robot: Robot) -> None:
    robot.say(order())
    robot.guard.cycle()
    robot.wheels.condition = WheelCondition(hazard="bumper left")
    robot.guard.cycle()
    assert robot.wheels.commands[-1] == STOP
    robot.wheels.condition = WheelCondition()
    robot.say(order(answers_ns=8))
    robot.guard.cycle()
    assert not robot.wheels.turning
    assert robot.agent.take(GuardReport)[-1].latch.model_dump() == {"stopped": True, "reason": "bumper left", "orders": 0}


def test_a_release_is_answered_but_not_carried_out_while_a_sensor_still_says_so(robot: Robot) -> None:
    robot.wheels.condition = WheelCondition(hazard="cliff left")
    robot.guard.cycle()
    robot.say(latch=release())
    robot.guard.cycle()
    assert robot.agent.take(GuardReport)[-1].latch.model_dump() == {"stopped": True, "reason": "cliff left", "orders": 1}
    robot.wheels.condition = WheelCondition()
    robot.guard.cycle()
    robot.say(latch=release())
    robot.say(order())
    robot.guard.cycle()
    assert robot.wheels.turning


def test_wheels_that_are_lost_are_reported_once_and_do_not_end_the_guard(robot: Robot) -> None:
    robot.say(order())
    robot.guard.cycle()
    robot.agent.take(GuardReport)
    lost = WheelCondition(trouble="wheels: /dev/ttyUSB0 is gone; trying again")
    robot.wheels.condition = lost
    for _ in range(3):
        robot.guard.cycle()
    [report] = robot.agent.take(GuardReport)
    assert (report.condition, report.applied) == (lost, STOP)
    robot.wheels.condition = WheelCondition(battery=0.5)
    robot.guard.cycle()
    assert robot.agent.take(GuardReport)[-1].condition == WheelCondition(battery=0.5)


def test_wheels_stand_before_the_guard_says_that_it_is_ready(robot: Robot) -> None:
    stops_when_ready: list[int] = []
    robot.wheels.during_read = lambda: stops_when_ready.extend(robot.wheels.stops for _ in robot.agent.take(GuardReport))
    robot.guard.run(lambda: robot.wheels.now_s > 100.1)
    assert stops_when_ready == [1]


def test_readings_are_handed_on_as_they_came(robot: Robot) -> None:
    readings = WheelReadings(until_ns=9, stamps_ns=Packed.of([3, 7], "i8"), angles_rad=Packed.of(np.eye(2), "f8"))
    robot.wheels.waiting, robot.wheels.refused = [readings], {"malformed": 2}
    robot.guard.cycle()
    [report] = robot.agent.take(GuardReport)
    assert report.readings == readings
    assert report.refused["malformed"] == 2


def test_wheels_stand_when_the_agent_is_gone_in_mid_drive(robot: Robot) -> None:
    robot.say(order())
    robot.wheels.during_read = lambda: robot.agent.close() if robot.wheels.turning else None
    robot.guard.run(never)
    assert len(robot.wheels.commands) == 3
    assert [robot.wheels.commands[0], robot.wheels.commands[-1]] == [STOP, STOP]


def test_wheels_stand_when_the_process_is_asked_to_end_in_mid_drive(robot: Robot) -> None:
    robot.wheels.during_read = lambda: robot.say(order())
    robot.guard.run(lambda: robot.wheels.now_s > 101.0)
    assert robot.wheels.commands[-2] != STOP
    assert robot.wheels.commands[-1] == STOP


@pytest.mark.parametrize("error", [DriverError("unplugged"), KeyboardInterrupt(), MemoryError()])
def test_wheels_are_told_to_stop_whatever_ends_the_guard_in_mid_drive(robot: Robot, error: BaseException) -> None:
    def fail() -> None:
        if robot.wheels.turning:
            raise error

    robot.say(order())
    robot.wheels.during_read = fail
    with pytest.raises(type(error)):
        robot.guard.run(never)
    assert robot.wheels.commands[-1] == STOP


def test_an_order_that_cannot_be_read_ends_the_guard_with_standing_wheels(robot: Robot) -> None:
    robot.agent.send(WheelCommand(left_rad_s=3.0, right_rad_s=4.0))
    with pytest.raises(DecodeError):
        robot.guard.run(never)
    assert robot.wheels.commands == [STOP, STOP]


def test_wheels_that_were_held_are_held_by_the_next_guard_until_they_are_released(robot: Robot, tmp_path: Path) -> None:
    def next_guard() -> Guard:
        return Guard(robot.wheels, robot.pipe, ServerStamps(LocalClock()), lambda: robot.wheels.now_s, LatchFile(tmp_path / "latch"))

    robot.guard = next_guard()
    robot.say(latch=stop("a cat"))
    robot.guard.cycle()
    robot.guard = next_guard()
    robot.say(order())
    robot.guard.cycle()
    assert not robot.wheels.turning
    assert robot.agent.take(GuardReport)[-1].latch.stopped
    robot.say(latch=release())
    robot.guard.cycle()
    robot.guard = next_guard()
    robot.say(order())
    robot.guard.cycle()
    assert robot.wheels.turning
