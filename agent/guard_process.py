"""The agent's side of its wheel guard: starts the process, keeps it convinced, and takes the wheels' readings from it."""

from __future__ import annotations

import logging
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Self

from agent.guard_pipe import GuardReport, Heartbeat, Pipe
from protocol.errors import DriverError
from protocol.messages import WheelReadings
from protocol.stopping import Stopped

_START_S = 20.0  # loading Python on a slow board, then the driver's own 10 s to find its wheels
_END_S = 1.0
_POLL_S = 0.05
_PACKAGES = Path(__file__).resolve().parents[1]  # started here, the guard takes no package from the folder of a user

_log = logging.getLogger(__name__)


class GuardProcess:
    """A running wheel guard. Use it as a context manager: the guard stops the wheels and ends with it, or with this process."""

    def __init__(self, process: subprocess.Popen[bytes], pipe: Pipe) -> None:
        self._process, self._pipe = process, pipe
        self._beats = 0
        self._refused: Mapping[str, int] = MappingProxyType({})
        self._ready = False

    @classmethod
    def start(cls, config_file: Path) -> Self:
        """Start the guard of the robot in a configuration file."""
        ours, theirs = socket.socketpair()
        with theirs:
            command = [sys.executable, "-m", "agent.guard", "--config", str(config_file.absolute()), "--pipe", str(theirs.fileno())]
            process = subprocess.Popen(command, cwd=_PACKAGES, pass_fds=[theirs.fileno()], stdin=subprocess.DEVNULL, start_new_session=True)
        return cls(process, Pipe(ours))

    @property
    def refused(self) -> Mapping[str, int]:
        """What the guard could not read, by reason."""
        return self._refused

    def wait_ready(self, stopping: Callable[[], bool]) -> None:
        """Wait until the guard has its wheels, and they stand. Raises DriverError where it fails, Stopped as soon as `stopping` says so."""
        deadline_s = time.monotonic() + _START_S
        while not self._ready:
            if stopping():
                raise Stopped
            if time.monotonic() > deadline_s:
                raise DriverError(f"the wheel guard is not ready after {_START_S:g} s")
            self.wait(_POLL_S)
            self.take()

    def beat(self) -> None:
        """Tell the guard that the agent's loop turns."""
        self._pipe.send(Heartbeat(count=self._beats))
        self._beats += 1

    def take(self) -> list[WheelReadings]:
        """Return the readings that have come, oldest first. Raises DriverError where the guard has ended."""
        reports = self._pipe.take(GuardReport)
        if reports and reports[-1].fault:
            raise DriverError(f"wheel guard: {reports[-1].fault}")
        if self._pipe.ended:
            raise DriverError("the wheel guard was ended by something else; without it no wheel may turn")
        if reports:
            self._ready, self._refused = True, reports[-1].refused
        return [report.readings for report in reports if report.readings is not None]

    def wait(self, timeout_s: float) -> None:
        """Sleep until the guard has said something, or the time is over."""
        self._pipe.wait(timeout_s)

    def close(self) -> None:
        """End the pipe, on which the guard stops the wheels and ends; one that does not is killed."""
        self._pipe.close()
        try:
            self._process.wait(_END_S)
        except subprocess.TimeoutExpired:
            if self._ready:  # before, it has not touched the wheels
                _log.error("the wheel guard does not end; it is killed, and the wheels may turn")
            self._process.kill()
            self._process.wait()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
