"""`python -m agent --config FILE`: one robot's agent, from its configuration file to its exit code."""

from __future__ import annotations

import argparse
import gc
import logging
import sys
from contextlib import ExitStack
from functools import partial
from pathlib import Path

import cv2

from agent.calibration import read_calibration
from agent.config import AgentConfig, load_config
from agent.drivers.bus_camera import BusCamera
from agent.helm_process import HelmProcess
from agent.methods import make_pipeline
from agent.process import new_epoch, run_until_stopped
from agent.service import Service
from protocol.news import News
from protocol.stage_clock import StageClock
from protocol.stopping import StopRequest, open_client

_log = logging.getLogger(__name__)


def run_agent(config_file: Path) -> int:
    """Run the agent of one robot until SIGTERM or SIGINT; return the exit code: 0, or 2 with one line that says what is wrong."""
    return run_until_stopped(config_file, load_config, partial(_serve, config_file))


def _serve(config_file: Path, config: AgentConfig, stop: StopRequest) -> None:
    """Start helm, links, camera and pipeline, and turn the loop between them; all of them end with it."""
    cv2.setNumThreads(1)  # one core is a robot's share of a machine, and one thread gives the same numbers on every machine
    calibration = read_calibration(config.camera.calibration)
    clock = StageClock()
    epoch = new_epoch()
    with ExitStack() as stack:
        helm = stack.enter_context(HelmProcess.start(config_file))  # first: it has the wheels stand
        news = stack.enter_context(News())
        news.watch(helm)
        bus = stack.enter_context(open_client(config.robot.site, config.robot.endpoint, stop.asked, news))
        world = stack.enter_context(open_client(config.robot.site, config.camera.endpoint, stop.asked, news))
        pipeline = make_pipeline(config.robot.name, epoch, config.robot.method, config.body.body(), calibration, clock)
        helm.wait_ready(stop.asked)
        camera = BusCamera(world, config.robot.name, (calibration.width_px, calibration.height_px), clock)
        gc.freeze()  # what is loaded by now lives as long as the process: no collection has to look through it
        _log.info("ready, epoch %d", epoch)
        Service(config, camera, helm, bus, pipeline, wait=news.wait, epoch=epoch, clock=clock).run(stop.asked)


def main(arguments: list[str]) -> int:
    """Run the agent as the command line says; return the exit code."""
    parser = argparse.ArgumentParser(prog="python -m agent", description="One robot's agent: maps what its camera sees.")
    parser.add_argument("--config", type=Path, required=True, metavar="FILE", help="TOML file; its keys and defaults: agent/config.py")
    return run_agent(parser.parse_args(arguments).config)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
