"""`python -m sim.firmware`: an emulated board on a pseudo-terminal, until it is asked to end. Its first line on stdout is `ready PORT`.

Lines on its stdin are orders (`sim/firmware/orders.py`), each answered by one line on stdout.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

from protocol.stopping import StopRequest
from sim.firmware.bench import Orders, run
from sim.firmware.create2 import Create2Rig
from sim.firmware.kinds import makers
from sim.firmware.motors import BENCH, LaggingMotors
from sim.firmware.orders import Surroundings
from sim.firmware.port import SerialPort
from sim.firmware.ros_arduino_bridge import ArduinoRig

BAD_USAGE = 2

_EXAMPLES = """examples:
  python -m sim.firmware ros_arduino_bridge --port /tmp/motors
  (then, on its stdin:  unplug  plug  reboot  lost 0.01  garbled 0.01  delay 0.1  echo on  device create2  sense 7 1  wheels)
"""


def main() -> int:
    """Run from the command line and return the exit code; whatever stops it becomes one line on stderr."""
    stop = StopRequest()
    arguments = parser().parse_args()
    devices = makers(
        ArduinoRig() if arguments.boot is None else ArduinoRig(boot_s=arguments.boot),
        Create2Rig() if arguments.boot is None else Create2Rig(boot_s=arguments.boot),
    )
    motors = LaggingMotors(BENCH, time.monotonic())
    try:
        port = SerialPort(devices[arguments.board](motors, time.monotonic()), arguments.port)
    except OSError as error:
        print(f"firmware: {arguments.port}: cannot be made a serial port ({error.strerror})", file=sys.stderr)
        return BAD_USAGE
    with port:
        print(f"ready {arguments.port}", flush=True)
        run(port, Surroundings(port, motors, devices), Orders(sys.stdin.fileno()), stop.asked)
    return 0


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
    return usage


if __name__ == "__main__":
    sys.exit(main())
