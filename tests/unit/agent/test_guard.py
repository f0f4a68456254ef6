"""When the wheel guard stops the wheels."""

from __future__ import annotations

import socket
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import pytest

from agent.guard import CYCLE_S, HEARTBEAT_LIMIT_S, Guard
from agent.guard_pipe import GuardReport, Heartbeat, Pipe
from protocol.errors import DriverError
from protocol.messages import Packed, WheelCommand, WheelReadings


@dataclass
class FakeWheels:
    """Wheels on a clock of their own: every read takes the whole time that it may."""

    now_s: float = 100.0
    stops: int = 0
    waiting: list[WheelReadings] = field(default_factory=list)
    refused: Mapping[str, int] = field(default_factory=dict)
    during_read: Callable[[], None] = lambda: None

    def read(self, timeout_s: float) -> Sequence[WheelReadings]:
        self.now_s += timeout_s
        self.during_read()
        taken, self.waiting = self.waiting, []
        return taken

    def drive(self, left_rad_s: float, right_rad_s: float) -> WheelCommand:
        raise AssertionError("nobody asked the wheels to turn")

    def stop(self) -> None:
        self.stops += 1

    def close(self) -> None: ...


@pytest.fixture
def wheels() -> FakeWheels:
    return FakeWheels()


@pytest.fixture
def ends() -> Iterator[tuple[Pipe, Pipe]]:
    agent, guard = socket.socketpair()
    with agent, guard:
        yield Pipe(agent), Pipe(guard)


def never() -> bool:
    return False


def test_cycle_lasts_20_ms_at_most() -> None:
    assert CYCLE_S == 0.02


def test_wheels_are_stopped_once_when_the_heartbeat_is_too_old(wheels: FakeWheels, ends: tuple[Pipe, Pipe]) -> None:
    agent, pipe = ends
    guard = Guard(wheels, pipe, lambda: wheels.now_s)
    agent.send(Heartbeat(count=0))
    guard.cycle()
    last_s = wheels.now_s
    while wheels.stops == 0:
        guard.cycle()
    assert HEARTBEAT_LIMIT_S < wheels.now_s - last_s <= HEARTBEAT_LIMIT_S + 2 * CYCLE_S
    for _ in range(100):
        guard.cycle()
    assert wheels.stops == 1


def test_heartbeats_keep_the_wheels_from_being_stopped_and_their_end_stops_them_again(wheels: FakeWheels, ends: tuple[Pipe, Pipe]) -> None:
    agent, pipe = ends
    guard = Guard(wheels, pipe, lambda: wheels.now_s)
    for silence in range(2):
        for count in range(50):
            agent.send(Heartbeat(count=count))
            guard.cycle()
        assert wheels.stops == silence
        for _ in range(20):
            guard.cycle()
        assert wheels.stops == silence + 1


def test_wheels_stand_before_the_guard_says_that_it_is_ready(wheels: FakeWheels, ends: tuple[Pipe, Pipe]) -> None:
    agent, pipe = ends
    stops_when_ready: list[int] = []
    wheels.during_read = lambda: stops_when_ready.extend(wheels.stops for _ in agent.take(GuardReport))
    Guard(wheels, pipe, lambda: wheels.now_s).run(lambda: wheels.now_s > 100.1)
    assert stops_when_ready == [1]


def test_readings_are_handed_on_as_they_came(wheels: FakeWheels, ends: tuple[Pipe, Pipe]) -> None:
    agent, pipe = ends
    readings = WheelReadings(until_ns=9, stamps_ns=Packed.of([3, 7], "i8"), angles_rad=Packed.of(np.eye(2), "f8"))
    wheels.waiting, wheels.refused = [readings], {"malformed": 2}
    Guard(wheels, pipe, lambda: wheels.now_s).cycle()
    [report] = agent.take(GuardReport)
    assert report.readings == readings
    assert report.refused["malformed"] == 2


def test_wheels_stand_when_the_agent_is_gone(wheels: FakeWheels, ends: tuple[Pipe, Pipe]) -> None:
    agent, pipe = ends
    wheels.during_read = agent.close
    Guard(wheels, pipe, lambda: wheels.now_s).run(never)
    assert wheels.stops == 2  # before and after


def test_wheels_stand_when_the_process_is_asked_to_end(wheels: FakeWheels, ends: tuple[Pipe, Pipe]) -> None:
    _, pipe = ends
    Guard(wheels, pipe, lambda: wheels.now_s).run(lambda: wheels.now_s > 101.0)
    assert wheels.stops == 2


def test_wheels_are_told_to_stop_even_when_their_encoders_are_lost(wheels: FakeWheels, ends: tuple[Pipe, Pipe]) -> None:
    def unplug() -> None:
        raise DriverError("unplugged")

    wheels.during_read = unplug
    with pytest.raises(DriverError):
        Guard(wheels, ends[1], lambda: wheels.now_s).run(never)
    assert wheels.stops == 2
