"""Stops a robot's wheels without any other part of it. `python -m agent.driving.stop_wheels --config FILE`.

It opens the serial port, says stop, and ends: at once, and with exit code 0, even where there is no port any more. Wheels of a simulated or
recorded world have none.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

from agent.config import BusWheelSettings, load_config
from agent.drivers.firmwares import firmware_of
from agent.drivers.serial_line import LineLost, SerialLine
from protocol.errors import OmmatidiaError

TIMES, PAUSE_S = 3, 0.03


def main(arguments: list[str]) -> int:
    """Stop the wheels of the robot in a configuration file; return the exit code: 0, or 2 where the file says nothing of any wheels."""
    parser = argparse.ArgumentParser(prog="python -m agent.driving.stop_wheels", description="Stops a robot's wheels, whatever else runs.")
    parser.add_argument("--config", type=Path, required=True, metavar="FILE", help="the agent's configuration file")
    try:
        wheels = load_config(parser.parse_args(arguments).config).wheels
    except OmmatidiaError as error:
        print(f"wheels not stopped: {error}", file=sys.stderr)
        return 2
    if not isinstance(wheels, BusWheelSettings):
        _stop(wheels.port, wheels.baud, firmware_of(wheels).command(0, 0))
    return 0


def _stop(port: str, baud: int, halt: bytes) -> None:
    """Say it more than once: the first may end a command that was half said. A port that is still open elsewhere is no hindrance."""
    try:
        line = SerialLine(port, baud, exclusive=False)
        for _ in range(TIMES):
            line.send(halt)
            time.sleep(PAUSE_S)
        line.close()
    except LineLost as lost:
        print(f"wheels not stopped: {port} {lost}", file=sys.stderr)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
