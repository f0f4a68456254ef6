"""The wheel guard: the robot's second process, which alone owns the wheels. `python -m agent.guard --config FILE --pipe FD`.

It turns at least every 20 ms, hands the wheels' readings to the agent, and stops the wheels when the agent's loop has stood still for
0.2 s, when the agent is gone, at SIGTERM or SIGINT, and on every other way out. It lives in a session of its own, so that whatever
ends the agent leaves it the time to do so.
"""

from __future__ import annotations

import argparse
import logging
import socket
import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path

from agent.config import load_config
from agent.drivers.bus_wheels import BusWheels
from agent.drivers.wheels import Wheels
from agent.guard_pipe import GuardReport, Heartbeat, Pipe
from agent.logs import start_logging
from protocol.errors import OmmatidiaError
from protocol.messages import WheelCommand, WheelReadings
from protocol.stopping import Stopped, StopRequest, open_client

CYCLE_S = 0.02
HEARTBEAT_LIMIT_S = 0.2

_STANDING = WheelCommand(left_rad_s=0.0, right_rad_s=0.0)

_log = logging.getLogger(__name__)


class Guard:
    """Stands between an agent and its wheels."""

    def __init__(self, wheels: Wheels, pipe: Pipe, clock_s: Callable[[], float] = time.monotonic) -> None:
        self._wheels, self._pipe, self._clock_s = wheels, pipe, clock_s
        self._beat_s: float | None = None  # when the agent's last heartbeat came; None while it is silent
        self._told = False

    def run(self, stopping: Callable[[], bool]) -> None:
        """Guard the wheels until the agent is gone or the process is asked to end; the wheels stand before and after."""
        try:
            self._wheels.stop()
            self._report(None)
            while not stopping() and not self._pipe.ended:
                self.cycle()
        finally:
            self._wheels.stop()

    def cycle(self) -> None:
        """Hand on what the wheels have read within 20 ms, and see whether the agent still turns."""
        for readings in self._wheels.read(CYCLE_S):
            self._report(readings)
        self._pipe.flush()
        self._listen()

    def _report(self, readings: WheelReadings | None) -> None:
        self._pipe.send(GuardReport(fault="", readings=readings, applied=_STANDING, refused=self._refused()))

    def _refused(self) -> Mapping[str, int]:
        return {**self._wheels.refused, "readings: agent too slow": self._pipe.lost}

    def _listen(self) -> None:
        """Take heartbeats; stop the wheels once when they stay away."""
        if self._pipe.take(Heartbeat):
            self._beat_s = self._clock_s()
        elif self._beat_s is not None and self._clock_s() - self._beat_s > HEARTBEAT_LIMIT_S:
            self._beat_s = None
            self._wheels.stop()
            _log.log(logging.DEBUG if self._told else logging.INFO, "the agent was silent for %.1f s: wheels stopped", HEARTBEAT_LIMIT_S)
            self._told = True


def main(arguments: list[str]) -> int:
    """Run the guard of the robot in a configuration file, over an inherited socket; return the exit code."""
    stop = StopRequest()
    parser = argparse.ArgumentParser(prog="agent.guard", description="The wheel guard; an agent starts it.")
    parser.add_argument("--config", type=Path, required=True)
    parser.add_argument("--pipe", type=int, required=True, help="file descriptor of the socket to the agent")
    options = parser.parse_args(arguments)
    start_logging("wheel guard")
    pipe = Pipe(socket.socket(fileno=options.pipe))
    try:
        _guard(options.config, pipe, stop)
    except Stopped:
        return 0
    except OmmatidiaError as error:
        pipe.send(GuardReport(fault=str(error), readings=None, applied=_STANDING, refused={}))  # the agent tells it to the person
        return 2
    return 0


def _guard(config_file: Path, pipe: Pipe, stop: StopRequest) -> None:
    config = load_config(config_file)

    def gone() -> bool:
        pipe.take(Heartbeat)
        return stop.asked() or pipe.ended

    with open_client(config.robot.site, config.wheels.endpoint, gone) as bus:
        Guard(BusWheels(bus, config.robot.name), pipe).run(stop.asked)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
