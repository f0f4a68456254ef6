"""`python -m sim`: a simulated world, until its scenario is over or it is asked to end. Its first line on stdout is `ready <endpoint>`."""

from __future__ import annotations

import argparse
import math
import sys
from pathlib import Path

import cv2

from protocol.errors import OmmatidiaError
from protocol.logs import start_logging
from protocol.stopping import StopRequest
from sim.arena import random_arena
from sim.scenario import Scenario, load_scenario, scenario_file
from sim.world_run import Plan, run_world

BAD_USAGE = 2

_EXAMPLES = """examples:
  python -m sim --seed 7 --robots 3 --out runs/arena-7
  python -m sim --scenario gate --clock real --out runs/gate --record
"""


def main() -> int:
    """Run from the command line and return the exit code; whatever stops it becomes one line on stderr."""
    stop = StopRequest()
    start_logging("world")
    cv2.setNumThreads(1)  # the robots need the other cores
    usage = parser()
    arguments = usage.parse_args()
    if arguments.clock == "real" and math.isinf(arguments.pace):
        usage.error("--clock real needs a finite --pace")
    if arguments.clock == "wall" and arguments.pace != 1.0:
        usage.error("--clock wall has the pace of the wall clock: leave --pace away")
    try:
        scenario = chosen_scenario(arguments)
        report = run_world(Plan(scenario, arguments.out, arguments.site, arguments.clock, arguments.pace, arguments.record), stop.asked)
    except OmmatidiaError as error:
        print(f"world: {' '.join(str(error).split())}", file=sys.stderr)
        return BAD_USAGE
    report.write(arguments.out)
    print(f"world: {report.sentence()}", file=sys.stderr)
    return 0


def chosen_scenario(arguments: argparse.Namespace) -> Scenario:
    """Return the scenario of a file, one that ships with the world, or a random arena; raises ConfigError."""
    scenario = (
        random_arena(arguments.seed, arguments.robots) if arguments.scenario is None else load_scenario(scenario_file(arguments.scenario))
    )
    return scenario if arguments.duration is None else scenario.model_copy(update={"duration_s": arguments.duration})


def parser() -> argparse.ArgumentParser:
    """Return what the command line understands."""
    usage = argparse.ArgumentParser(
        prog="python -m sim",
        description="A simulated world, on a router of its own, for the drivers of its robots.",
        epilog=_EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    what = usage.add_mutually_exclusive_group(required=True)
    what.add_argument("--scenario", metavar="FILE", help="a TOML file, or the name of a scenario that ships with the world")
    what.add_argument("--seed", type=_count, metavar="N", help="a random arena")
    usage.add_argument("--robots", type=_count, default=3, metavar="N", help="in a random arena (default: 3)")
    usage.add_argument("--site", default="world", help="name of the site on the world's router (default: world)")
    usage.add_argument(
        "--clock",
        choices=("lockstep", "real", "wall"),
        default="lockstep",
        help="wait for every robot's answer, or for nobody; `wall` also stamps in wall time and drops pictures that it is too slow for",
    )
    usage.add_argument("--pace", type=_pace, default=1.0, help="world time over real time at most, or `max` (default: 1.0)")
    usage.add_argument("--duration", type=_positive, metavar="S", help="seconds of world time (default: as the scenario says)")
    usage.add_argument("--out", type=Path, required=True, metavar="DIR", help="where handout, truth and report go")
    usage.add_argument("--record", action="store_true", help="keep frames and wheel angles too, so that DIR is a whole recording")
    return usage


def _count(text: str) -> int:
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"{text} is not a whole number")
    return int(text)


def _pace(text: str) -> float:
    return math.inf if text == "max" else _positive(text)


def _positive(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0.0 < value < math.inf:
        raise argparse.ArgumentTypeError(f"{text} is not a positive number")
    return value


if __name__ == "__main__":
    sys.exit(main())
