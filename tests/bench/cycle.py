"""`python -m tests.bench.cycle`: how long a wheel guard takes from one reading of the encoders to the next, with a command in each cycle.

A guard in its own process drives an emulated board of each kind. The stamps of the readings tell the cycles.
"""

from __future__ import annotations

import select
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from agent.clocks.clock_map import ClockMap
from agent.clocks.local_clock import LocalClock
from agent.driving.guard_pipe import DriveOrder
from agent.driving.guard_process import GuardProcess
from deploy.unwinding import unwind_on_signals
from protocol.geometry import Array
from tests.emulated_board import emulated_board
from tests.serial_robot import write_serial_robot

BOARDS = {"ros_arduino_bridge": ("--boot", "0.3"), "create2": ()}  # and what their emulators are told
MEASURED_S = 10.0
LIMIT_MS = 20.0

_TURN_S = 0.05  # of the helm
_ORDER = DriveOrder(left_rad_s=1.0, right_rad_s=1.0, valid_s=0.4, answers_ns=0)


def main() -> int:
    """Print a line for each board; return 1 where the median cycle of one is longer than it may be."""
    unwind_on_signals()
    holds = True
    for board, told in BOARDS.items():
        with tempfile.TemporaryDirectory() as folder, emulated_board(board, Path(folder) / "wheels", *told) as emulated:
            cycles_ms = 1e-6 * np.diff(_stamps_ns(write_serial_robot(Path(folder), board, emulated.port)))
        median_ms, late_ms = np.percentile(cycles_ms, [50.0, 99.0])
        print(f"{board:18} {len(cycles_ms)} cycles: median {median_ms:.1f} ms (bound {LIMIT_MS:g} ms), 99th percentile {late_ms:.1f} ms")
        holds = holds and median_ms <= LIMIT_MS
    return 0 if holds else 1


def _stamps_ns(config_file: Path) -> Array:
    """Return when a guard read the encoders, (n,) [ns], while it was given an order for each message that it sent."""
    stamps_ns: list[int] = []
    with GuardProcess.start(config_file, LocalClock()) as guard:
        guard.wait_ready(lambda: False)
        until_s = time.monotonic() + MEASURED_S
        while time.monotonic() < until_s:
            now_ns = time.monotonic_ns()
            guard.stamp_by(ClockMap(local_ns=now_ns, server_ns=now_ns, rate=1.0, sigma_s=0.0))
            guard.instruct(_ORDER)
            select.select([guard], [], [], _TURN_S)
            stamps_ns += [stamp for readings in guard.take() for stamp in readings.stamps_ns.array().tolist()]
    return np.array(stamps_ns)


if __name__ == "__main__":
    sys.exit(main())
