"""`python -m agent.range_bearing --config FILE`: the agent of a robot without a camera, until SIGTERM or SIGINT."""

from __future__ import annotations

import argparse
import logging
import sys
import time
from contextlib import ExitStack
from pathlib import Path

from agent.logs import start_logging
from agent.range_bearing.config import RangeBearingConfig, load_config
from agent.range_bearing.service import RangeBearingService
from protocol.errors import OmmatidiaError
from protocol.news import News
from protocol.stopping import Stopped, StopRequest, open_client

BAD_USAGE = 2

_log = logging.getLogger(__name__)


def main(arguments: list[str]) -> int:
    """Run as the command line says; return the exit code: 0, or 2 with one line that says what is wrong."""
    parser = argparse.ArgumentParser(prog="python -m agent.range_bearing", description="The agent of a robot without a camera.")
    parser.add_argument("--config", type=Path, required=True, metavar="FILE", help="TOML file; its keys: agent/range_bearing/config.py")
    stop = StopRequest()
    start_logging("agent")
    try:
        config = load_config(parser.parse_args(arguments).config)
        start_logging(f"agent {config.robot.name}")
        _log.info("starting with %s", config.model_dump_json())
        _serve(config, stop)
    except Stopped:
        return 0
    except OmmatidiaError as error:
        if stop.asked():
            return 0  # whatever ended while everything was asked to end
        _log.error("%s", error)
        return BAD_USAGE
    return 0


def _serve(config: RangeBearingConfig, stop: StopRequest) -> None:
    with ExitStack() as stack:
        news = stack.enter_context(News())
        swarm = stack.enter_context(open_client(config.robot.site, config.robot.endpoint, stop.asked, news))
        world = stack.enter_context(open_client(config.robot.site, config.sensor.endpoint, stop.asked, news))
        epoch = time.time_ns() // 1_000_000  # grows with every start
        RangeBearingService(config, swarm, world, wait=news.wait, epoch=epoch).run(stop.asked)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
