"""The agent's side of its helm: when it is ready, what it says, and how it ends."""

from __future__ import annotations

import socket
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pytest

from agent.clocks.clock_map import ServerStamps
from agent.clocks.local_clock import LocalClock
from agent.drivers.wheels import WheelCondition
from agent.driving.child import Child
from agent.driving.helm_pipe import HelmReport, Look
from agent.driving.helm_process import HelmProcess
from agent.driving.pipe import Pipe
from protocol.errors import DriverError
from protocol.fields import Packed
from protocol.messages import WheelReadings
from protocol.stopping import Stopped
from tests.unit.agent.control.local_maps import local_map

WELL = WheelCondition(battery=0.7)
READINGS = WheelReadings(until_ns=5, stamps_ns=Packed.of([5], "i8"), angles_rad=Packed.of([[0.1, 0.2]], "f8"))


@dataclass
class Ends:
    """The agent's view of a helm, and the helm's end of the pipe; the process itself only waits for its input to end."""

    helm: HelmProcess
    pipe: Pipe
    process: subprocess.Popen[bytes]

    def report(self, fault: str = "", readings: WheelReadings | None = None) -> None:
        self.pipe.send(HelmReport(fault=fault, readings=readings, drive="slowed", why="a cat", wheels=WELL, refused={"malformed": 1}))


@pytest.fixture
def ends() -> Iterator[Ends]:
    ours, theirs = socket.socketpair()
    process = subprocess.Popen([sys.executable, "-c", "input()"], stdin=theirs.fileno(), stderr=subprocess.DEVNULL)
    with ours, theirs:
        yield Ends(HelmProcess(Child("helm", process, Pipe(ours)), ServerStamps(LocalClock())), Pipe(theirs), process)
        process.kill()
        process.wait()


def never() -> bool:
    return False


def test_helm_is_ready_with_its_first_report(ends: Ends) -> None:
    assert ends.helm.fares == ("standing", "")
    ends.report()
    ends.helm.wait_ready(never)
    ends.report(readings=READINGS)
    assert ends.helm.take() == [READINGS]
    assert ends.helm.fares == ("slowed", "a cat")
    assert ends.helm.wheels == WELL
    assert ends.helm.refused == {"malformed": 1}


def test_what_the_agent_sees_reaches_the_helm(ends: Ends) -> None:
    seen = local_map(100)
    ends.helm.see(seen, np.array([0.1, 0.2]))
    assert ends.pipe.take(Look) == [Look(local_map=seen, angles_rad=(0.1, 0.2))]


def test_helm_that_fails_says_why(ends: Ends) -> None:
    ends.report(fault="wheel guard: nobody answers at tcp/10.0.0.1:7447 within 10 s")
    with pytest.raises(DriverError, match="wheel guard: nobody answers at"):
        ends.helm.wait_ready(never)


def test_helm_that_ends_without_a_word_is_noticed(ends: Ends) -> None:
    ends.report()
    ends.helm.wait_ready(never)
    ends.pipe.close()
    ends.process.kill()
    ends.process.wait()
    with pytest.raises(DriverError, match="the helm was ended by something else"):
        ends.helm.take()


def test_waiting_for_the_helm_ends_when_the_agent_is_asked_to_end(ends: Ends) -> None:
    with pytest.raises(Stopped):
        ends.helm.wait_ready(lambda: True)


def test_closing_ends_the_pipe_and_waits_for_the_process(ends: Ends) -> None:
    with ends.helm:
        assert ends.process.poll() is None
    assert ends.process.returncode is not None
    assert ends.pipe.take(Look) == []
    assert ends.pipe.ended
