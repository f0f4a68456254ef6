"""`python -m agent.range_bearing --config FILE`: the agent of a robot without a camera, until SIGTERM or SIGINT."""

from __future__ import annotations

import argparse
import sys
from contextlib import ExitStack
from pathlib import Path

from agent.process import new_epoch, run_until_stopped
from agent.range_bearing.config import RangeBearingConfig, load_config
from agent.range_bearing.service import RangeBearingService
from protocol.news import News
from protocol.stopping import StopRequest, open_client


def main(arguments: list[str]) -> int:
    """Run as the command line says; return the exit code: 0, or 2 with one line that says what is wrong."""
    parser = argparse.ArgumentParser(prog="python -m agent.range_bearing", description="The agent of a robot without a camera.")
    parser.add_argument("--config", type=Path, required=True, metavar="FILE", help="TOML file; its keys: agent/range_bearing/config.py")
    return run_until_stopped(parser.parse_args(arguments).config, load_config, _serve)


def _serve(config: RangeBearingConfig, stop: StopRequest) -> None:
    with ExitStack() as stack:
        news = stack.enter_context(News())
        swarm = stack.enter_context(open_client(config.robot.site, config.robot.endpoint, stop.asked, news))
        world = stack.enter_context(open_client(config.robot.site, config.sensor.endpoint, stop.asked, news))
        RangeBearingService(config, swarm, world, wait=news.wait, epoch=new_epoch()).run(stop.asked)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
