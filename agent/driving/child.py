"""A further process of a robot, with a pipe to the one that started it: how it is started, heard for the first time, and ended."""

from __future__ import annotations

import argparse
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Self

from agent.clocks.local_clock import LocalClock, parse_clock
from agent.driving.pipe import Pipe
from protocol.errors import DriverError, OmmatidiaError
from protocol.fields import Message
from protocol.logs import start_logging
from protocol.stopping import Stopped, StopRequest

Body = Callable[[Path, LocalClock, Pipe, StopRequest], None]  # configuration file, the robot's clock, the pipe, and when to end

START_S = 20.0  # loading Python on a slow board, then a driver's own 10 s to find its wheels
_POLL_S = 0.05
_PACKAGES = Path(__file__).resolve().parents[2]  # started here, a child takes no package from the folder of a user


class Child:
    """A module that runs in a session of its own, so that whatever ends this process leaves it the time to end well."""

    def __init__(self, name: str, process: subprocess.Popen[bytes], pipe: Pipe) -> None:
        self.pipe = pipe
        self._name, self._process = name, process

    @classmethod
    def start(cls, name: str, module: str, config_file: Path, clock: LocalClock) -> Self:
        """Start a module for the robot in a configuration file, by the same clock; `name` is what a person calls it."""
        ours, theirs = socket.socketpair()
        with theirs:
            told = ["--config", str(config_file.absolute()), "--clock", clock.argument(), "--pipe", str(theirs.fileno())]
            command = [sys.executable, "-m", module, *told]
            process = subprocess.Popen(command, cwd=_PACKAGES, pass_fds=[theirs.fileno()], stdin=subprocess.DEVNULL, start_new_session=True)
        return cls(name, process, Pipe(ours))

    def wait_ready(self, is_ready: Callable[[], bool], stopping: Callable[[], bool]) -> None:
        """Wait until it is ready. Raises DriverError where that takes too long, Stopped as soon as `stopping` says so."""
        deadline_s = time.monotonic() + START_S
        while not is_ready():
            if stopping():
                raise Stopped
            if time.monotonic() > deadline_s:
                raise DriverError(f"the {self._name} is not ready after {START_S:g} s")
            self.pipe.wait(_POLL_S)

    def end(self, limit_s: float) -> int:
        """End the pipe, on which the child ends, and kill it if it does not in time; return its exit code, negative where it was killed."""
        self.pipe.close()
        try:
            return self._process.wait(limit_s)
        except subprocess.TimeoutExpired:
            self._process.kill()
            return self._process.wait()


def serve(module: str, name: str, about: str, arguments: Sequence[str], body: Body, failed: Callable[[str], Message]) -> int:
    """Run a child with what it was told on its command line, until its body returns; return the exit code.

    What ends it early is told over the pipe, as `failed` puts it: the agent tells it to the person.
    """
    stop = StopRequest()
    config_file, clock, pipe = _told(module, about, arguments)
    start_logging(name)
    try:
        body(config_file, clock, pipe, stop)
    except Stopped:
        return 0
    except OmmatidiaError as error:
        pipe.send(failed(str(error)))
        return 2
    return 0


def _told(module: str, about: str, arguments: Sequence[str]) -> tuple[Path, LocalClock, Pipe]:
    """Return what the child was told on its command line: the robot's configuration file, its clock, and its own end of the pipe."""
    parser = argparse.ArgumentParser(prog=module, description=about)
    parser.add_argument("--config", type=Path, required=True)
    parser.add_argument("--clock", default="", help="which clock the robot goes by")
    parser.add_argument("--pipe", type=int, required=True, help="file descriptor of the socket to the process that started it")
    options = parser.parse_args(arguments)
    return options.config, parse_clock(options.clock), Pipe(socket.socket(fileno=options.pipe))
