"""The helm: the robot's second process, which answers setpoints. `python -m agent.driving.helm --config FILE --pipe FD`.

A picture is long in work, and setpoints cannot wait for it: so the agent sees in its own process, and this one steers by what it has seen.
The helm starts the wheel guard and ends with the agent, in a session of its own, so that whatever ends the agent leaves it the time to.
"""

from __future__ import annotations

import gc
import sys
from contextlib import ExitStack
from functools import partial
from pathlib import Path

from agent.clocks.local_clock import LocalClock
from agent.config import load_config
from agent.drivers.wheels import WheelCondition
from agent.driving.child import serve
from agent.driving.guard_process import GuardProcess
from agent.driving.helm_pipe import HelmReport, Look
from agent.driving.pipe import Pipe
from agent.driving.steering import Steering
from protocol.news import News
from protocol.stopping import StopRequest, await_client


def main(arguments: list[str]) -> int:
    """Steer the robot in a configuration file, over an inherited socket; return the exit code."""
    return serve("agent.driving.helm", "helm", "The helm; an agent starts it.", arguments, _steer, _failed)


def _failed(fault: str) -> HelmReport:
    return HelmReport(fault=fault, readings=None, drive="standing", why="", wheels=WheelCondition(), refused={})


def _steer(config_file: Path, clock: LocalClock, pipe: Pipe, stop: StopRequest) -> None:
    """Start guard and link, and steer; the guard ends with it."""

    def gone() -> bool:
        pipe.take(Look)
        return stop.asked() or pipe.ended

    if gone():
        return  # while Python was loading; a guard would have to be loaded as well, only to end
    with ExitStack() as stack:
        guard = stack.enter_context(GuardProcess.start(config_file, clock))  # first: from here on the wheels stand
        config = load_config(config_file)
        news = stack.enter_context(News())
        news.watch(guard)
        news.watch(pipe)
        guard.wait_ready(gone)
        waiting = partial(_tell_waiting, config.robot.endpoint, guard, pipe)
        bus = stack.enter_context(await_client(config.robot.site, config.robot.endpoint, gone, news, waiting))
        steering = Steering(config, bus, guard, pipe, clock)
        gc.freeze()  # what is loaded by now lives as long as the process: no collection has to look through it, and hold up the wheels
        steering.run(stop.asked, news.wait)


def _tell_waiting(endpoint: str, guard: GuardProcess, pipe: Pipe) -> None:
    """Tell the agent that there is no map server yet, and how the wheels fare, which stand. Raises DriverError where the guard is lost."""
    guard.take()
    why = f"no map server at {endpoint} yet: standing"
    refused = dict(guard.refused)
    pipe.send(HelmReport(fault="", readings=None, drive="standing", why=why, wheels=guard.condition, refused=refused, is_linked=False))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
