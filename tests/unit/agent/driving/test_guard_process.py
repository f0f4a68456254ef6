"""The helm's side of its wheel guard: when it is ready, and how it ends."""

from __future__ import annotations

import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass

import pytest

from agent.drivers.wheels import WheelCondition
from agent.driving.child import Child
from agent.driving.guard_pipe import DriveOrder, GuardReport, Instruction, Latch, LatchOrder
from agent.driving.guard_process import GuardProcess
from agent.driving.pipe import Pipe
from protocol.errors import DriverError
from protocol.fields import Packed
from protocol.messages import WheelCommand, WheelReadings
from protocol.stopping import Stopped

TURNING = WheelCommand(left_rad_s=1.0, right_rad_s=2.0, answers_ns=7)
WELL = WheelCondition(battery=0.7)
HELD = Latch(stopped=True, reason="a cat", orders=1)
READINGS = WheelReadings(until_ns=5, stamps_ns=Packed.of([5], "i8"), angles_rad=Packed.of([[0.1, 0.2]], "f8"))


@dataclass
class Ends:
    """The helm's view of a guard, and the guard's end of the pipe; the process itself only waits for its input to end."""

    guard: GuardProcess
    pipe: Pipe
    process: subprocess.Popen[bytes]

    def report(self, fault: str = "", readings: WheelReadings | None = None) -> None:
        self.pipe.send(GuardReport(fault=fault, readings=readings, applied=TURNING, latch=HELD, condition=WELL, refused={"malformed": 1}))


@pytest.fixture
def ends() -> Iterator[Ends]:
    ours, theirs = socket.socketpair()
    process = subprocess.Popen([sys.executable, "-c", "input()"], stdin=theirs.fileno(), stderr=subprocess.DEVNULL)
    with ours, theirs:
        yield Ends(GuardProcess(Child("wheel guard", process, Pipe(ours))), Pipe(theirs), process)
        process.kill()
        process.wait()


def never() -> bool:
    return False


def test_guard_is_ready_with_its_first_report(ends: Ends) -> None:
    ends.report()
    ends.guard.wait_ready(never)
    ends.report(readings=READINGS)
    assert ends.guard.take() == [READINGS]
    assert ends.guard.refused == {"malformed": 1}


def test_whether_the_wheels_are_held_is_known_from_the_reports(ends: Ends) -> None:
    assert not ends.guard.latch.stopped
    ends.report()
    ends.guard.take()
    assert ends.guard.latch == HELD


def test_how_the_wheels_fare_is_known_from_the_reports(ends: Ends) -> None:
    ends.report()
    ends.guard.take()
    assert ends.guard.condition == WELL


def test_guard_that_fails_says_why_even_when_it_is_still_running(ends: Ends) -> None:
    ends.report(fault="nobody answers at tcp/10.0.0.1:7447 within 10 s")
    with pytest.raises(DriverError, match="wheel guard: nobody answers at"):
        ends.guard.wait_ready(never)


def test_guard_that_ends_without_a_word_is_noticed(ends: Ends) -> None:
    ends.report()
    ends.guard.wait_ready(never)
    ends.pipe.close()
    ends.process.kill()
    ends.process.wait()
    with pytest.raises(DriverError, match="ended by something else"):
        ends.guard.take()


def test_waiting_for_the_guard_ends_when_the_helm_is_asked_to_end(ends: Ends) -> None:
    with pytest.raises(Stopped):
        ends.guard.wait_ready(lambda: True)


def test_instructions_reach_the_guard(ends: Ends) -> None:
    drive = DriveOrder(left_rad_s=1.0, right_rad_s=2.0, valid_s=0.4, answers_ns=7)
    latch = LatchOrder(order="release", reason="")
    ends.guard.instruct()
    ends.guard.instruct(drive)
    ends.guard.instruct(latch=latch)
    taken = ends.pipe.take(Instruction)
    assert [(each.count, each.drive, each.latch) for each in taken] == [(0, None, None), (1, drive, None), (2, None, latch)]
    assert 0.0 < taken[0].sent_s <= taken[2].sent_s <= time.monotonic()


def test_closing_ends_the_pipe_and_waits_for_the_process(ends: Ends) -> None:
    with ends.guard:
        assert ends.process.poll() is None
    assert ends.process.returncode is not None
    assert ends.pipe.take(Instruction) == []
    assert ends.pipe.ended
