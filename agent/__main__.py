"""`python -m agent --config FILE`: one robot's agent, from its configuration file to its exit code."""

from __future__ import annotations

import argparse
import gc
import logging
import sys
from contextlib import ExitStack, closing
from functools import partial
from pathlib import Path

import cv2

from agent.calibration import read_calibration
from agent.camera_watch import CameraWatch
from agent.clocks.clock_map import ServerStamps
from agent.clocks.local_clock import parse_clock
from agent.config import AgentConfig, load_config
from agent.drivers.open_camera import open_camera
from agent.driving.helm_process import HelmProcess
from agent.methods import make_pipeline
from agent.process import new_epoch, run_until_stopped
from agent.service import Service
from protocol.news import News
from protocol.service_manager import ServiceManager
from protocol.stage_clock import StageClock
from protocol.stopping import StopRequest, await_client

_log = logging.getLogger(__name__)


def run_agent(config_file: Path, clock: str = "") -> int:
    """Run the agent of one robot until SIGTERM or SIGINT; return the exit code: 0, or 2 with one line that says what is wrong.

    `clock` names the clock that the robot goes by (agent/clocks/local_clock.py).
    """
    return run_until_stopped(config_file, load_config, partial(_serve, config_file, clock))


def _serve(config_file: Path, clock: str, config: AgentConfig, stop: StopRequest) -> None:
    """Start helm, links, camera and pipeline, and turn the loop between them; all of them end with it."""
    local_clock = parse_clock(clock)
    stamps = ServerStamps(local_clock)  # a camera with times of its own turns them into stamps by this
    cv2.setNumThreads(1)  # one core is a robot's share of a machine, and one thread gives the same numbers on every machine
    calibration = read_calibration(config.camera.calibration)
    stage_clock = StageClock()
    epoch = new_epoch()
    with ExitStack() as stack:
        manager = stack.enter_context(ServiceManager())
        helm = stack.enter_context(HelmProcess.start(config_file, local_clock, stamps))  # first: it has the wheels stand
        news = stack.enter_context(News())
        news.watch(helm)
        helm.wait_ready(stop.asked)
        waiting = partial(_wait_for_server, config.robot.endpoint, helm, manager)
        bus = stack.enter_context(await_client(config.robot.site, config.robot.endpoint, stop.asked, news, waiting))
        pipeline = make_pipeline(config.robot.name, epoch, config.robot.method, config.body.body(), calibration, stage_clock)
        helm.wait_linked(partial(_turning, stop, manager))
        size_px = (calibration.width_px, calibration.height_px)
        camera = open_camera(
            config.robot, config.camera, size_px, news=news, stopping=stop.asked, stamp_ns=stamps.stamp_ns, clock=stage_clock
        )
        stack.enter_context(closing(camera))
        watch = CameraWatch(calibration, config.body.body())
        gc.freeze()  # what is loaded by now lives as long as the process: no collection has to look through it
        _log.info("ready, epoch %d", epoch)
        service = Service(config, camera, helm, bus, pipeline, watch=watch, wait=news.wait, manager=manager, epoch=epoch, clock=stage_clock)
        service.run(stop.asked)


def _wait_for_server(endpoint: str, helm: HelmProcess, manager: ServiceManager) -> None:
    """Tell systemd that the robot stands ready and waits for its map server. Raises DriverError where the helm is lost."""
    helm.take()
    if manager.fares(f"no map server at {endpoint} yet: standing"):
        _log.warning("nobody answers at %s: is the map server running? Waiting for it", endpoint)
    manager.ready()
    manager.turn()


def _turning(stop: StopRequest, manager: ServiceManager) -> bool:
    """Tell systemd that a loop turns, and return whether it is to end."""
    manager.turn()
    return stop.asked()


def main(arguments: list[str]) -> int:
    """Run the agent as the command line says; return the exit code."""
    parser = argparse.ArgumentParser(prog="python -m agent", description="One robot's agent: maps what its camera sees.")
    parser.add_argument("--config", type=Path, required=True, metavar="FILE", help="TOML file; its keys and defaults: agent/config.py")
    parser.add_argument(
        "--clock", default="", metavar="KEY=NUMBER,...", help="go by a bad clock, to try one out; keys: agent/clocks/local_clock.py"
    )
    options = parser.parse_args(arguments)
    return run_agent(options.config, options.clock)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
