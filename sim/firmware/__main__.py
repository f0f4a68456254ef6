"""`python -m sim.firmware`: an emulated board on a pseudo-terminal, until it is asked to end. Its first line on stdout is `ready PORT`.

Lines on its stdin are orders (`sim/firmware/orders.py`), each answered by one line on stdout.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from pathlib import Path

from protocol.errors import ConfigError, OmmatidiaError
from protocol.news import News
from protocol.stopping import Stopped, StopRequest, open_client
from sim.firmware.bench import Orders, run
from sim.firmware.board import Motors
from sim.firmware.create2 import Create2Rig
from sim.firmware.kinds import makers
from sim.firmware.motors import BENCH, LaggingMotors
from sim.firmware.orders import Surroundings
from sim.firmware.port import SerialPort
from sim.firmware.ros_arduino_bridge import ArduinoRig
from sim.firmware.world_link import WorldLink
from sim.scenario import load_scenario, scenario_file
from sim.staging import drive_of

BAD_USAGE = 2

_EXAMPLES = """examples:
  python -m sim.firmware create2 --port /tmp/motors --scenario gate --robot r1 --world tcp/127.0.0.1:7447
  python -m sim.firmware ros_arduino_bridge --port /tmp/motors
  (then, on its stdin:  unplug  plug  reboot  lost 0.01  garbled 0.01  delay 0.1  echo on  device create2  sense 7 1  wheels)
"""


def main() -> int:
    """Run from the command line and return the exit code; whatever stops it becomes one line on stderr."""
    stop = StopRequest()
    usage = parser()
    arguments = usage.parse_args()
    if (arguments.world is None) != (arguments.robot is None) or (arguments.world is None) != (arguments.scenario is None):
        usage.error("wheels in a world need --world, --scenario and --robot")
    try:
        if arguments.world is None:
            motors = LaggingMotors(BENCH, time.monotonic())
            _run(arguments, ArduinoRig(), motors, lambda _now_s: None, stop.asked)
        else:
            _run_in_world(arguments, stop.asked)
    except Stopped:
        return 0
    except OmmatidiaError as error:
        print(f"firmware: {' '.join(str(error).split())}", file=sys.stderr)
        return BAD_USAGE
    return 0


def _run_in_world(arguments: argparse.Namespace, stopping: Callable[[], bool]) -> None:
    robots = {robot.name: robot for robot in load_scenario(scenario_file(arguments.scenario)).robots}
    if arguments.robot not in robots:
        raise ConfigError(f"{arguments.scenario}: there is no robot {arguments.robot}")
    robot = robots[arguments.robot]
    with News() as news, open_client(arguments.site, arguments.world, stopping, news) as bus:
        link = WorldLink(bus, robot.name, drive_of(robot), robot.truth.command_delay_s)
        rig = ArduinoRig(encoder_ticks_per_rev=robot.rig.encoder_ticks_per_rev)
        _run(arguments, rig, link.motors, link.turn, stopping)


def _run(
    arguments: argparse.Namespace, arduino: ArduinoRig, motors: Motors, turn_world: Callable[[float], None], stopping: Callable[[], bool]
) -> None:
    boot = {} if arguments.boot is None else {"boot_s": arguments.boot}
    devices = makers(arduino._replace(**boot), Create2Rig(**boot))
    try:
        port = SerialPort(devices[arguments.board](motors, time.monotonic()), arguments.port)
    except OSError as error:
        raise ConfigError(f"{arguments.port}: cannot be made a serial port ({error.strerror})") from None
    with port:
        print(f"ready {arguments.port}", flush=True)
        run(port, Surroundings(port, motors, devices), Orders(sys.stdin.fileno()), stopping, turn_world)


def parser() -> argparse.ArgumentParser:
    """Return what the command line understands."""
    usage = argparse.ArgumentParser(
        prog="python -m sim.firmware",
        description="An emulated motor controller board, with motors of its own, on a pseudo-terminal.",
        epilog=_EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    usage.add_argument("board", choices=sorted(makers(ArduinoRig(), Create2Rig())), help="what is at the end of the line")
    usage.add_argument("--port", type=Path, required=True, metavar="PATH", help="name that leads to the line while it is plugged in")
    usage.add_argument("--boot", type=float, metavar="S", help="seconds for which a board is deaf after it has lost power")
    world = usage.add_argument_group("wheels in a simulated world", "instead of motors of its own; the world runs with --clock wall")
    world.add_argument("--world", metavar="ENDPOINT", help="where its router is")
    world.add_argument("--site", default="world", help="name of the site on the world's router (default: world)")
    world.add_argument("--scenario", metavar="FILE", help="the world's scenario: a TOML file, or the name of one that ships with the world")
    world.add_argument("--robot", metavar="NAME", help="whose wheels they are")
    return usage


if __name__ == "__main__":
    sys.exit(main())
