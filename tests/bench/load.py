"""`python -m tests.bench.load`: what a robot's processes take of one core and of the memory, at 640x480 and 10 pictures a second.

One robot explores an arena on an emulated motor controller, in a world on the wall clock. Where the machine is too busy for all pictures,
the agent's processor time is scaled to those that it took, and those that wait for it count as its memory.
"""

from __future__ import annotations

import os
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

from deploy.unwinding import unwind_on_signals
from tests.firmware_swarm import FirmwareSwarm, running_firmware_swarm
from tests.loopback.family import only_child

RATE_HZ, WARM_UP_S, MEASURED_S = 10.0, 8.0, 20.0
MAX_SHARE, MAX_MB = 0.20, 200.0  # of agent and guard together: a core, and resident memory
_ENOUGH = 0.95  # of the pictures

SCENARIO = f"""
duration_s = 600.0
camera = {{ width_px = 640, height_px = 480, rate_hz = {RATE_HZ} }}
boxes = [{{ centre_m = [0.7, 0.5], size_m = [0.3, 0.2], height_m = 0.15 }}]
robots = [{{ name = "r1", start = [-1.0, 0.0, 0.0], rig = {{ encoder_ticks_per_rev = 1920 }} }}]
"""
EXPLORE = {"kind": "explore", "bounds": [-2.0, -1.5, 2.0, 1.5]}


class Taken(NamedTuple):
    """What a process has taken so far."""

    processor_s: float
    resident_mb: float


def main() -> int:
    """Print a line for each process and one for the bound; return 1 where it is missed."""
    unwind_on_signals()
    with tempfile.TemporaryDirectory() as folder:
        scenario = Path(folder) / "load.toml"
        scenario.write_text(SCENARIO)
        with running_firmware_swarm(scenario, {"r1": "ros_arduino_bridge"}, EXPLORE, Path(folder), clocks={}) as swarm:
            shares, memory_mb = _measured(swarm)
    for name, share in shares.items():
        print(f"{name:6} {100.0 * share:5.1f} % of one core, {memory_mb[name]:4.0f} MB resident")
    share, most_mb = shares["agent"] + shares["guard"], memory_mb["agent"] + memory_mb["guard"]
    holds = share < MAX_SHARE and most_mb < MAX_MB
    print(f"agent and guard: {100.0 * share:.1f} % of one core (bound {100.0 * MAX_SHARE:.0f} %), {most_mb:.0f} MB (bound {MAX_MB:.0f} MB)")
    return 0 if holds else 1


def _measured(swarm: FirmwareSwarm) -> tuple[dict[str, float], dict[str, float]]:
    """Return each process's share of a core at the full rate of pictures, and its resident memory [MB]."""
    agent = swarm.processes.pids["r1"]
    pids = {"agent": agent, "helm": only_child(agent), "guard": only_child(only_child(agent))}
    _serve(swarm, WARM_UP_S)
    before, frames = {name: _taken(pid) for name, pid in pids.items()}, _frames(swarm)
    _serve(swarm, MEASURED_S)
    after, frames = {name: _taken(pid) for name, pid in pids.items()}, _frames(swarm) - frames
    busy = "" if frames >= _ENOUGH * RATE_HZ * MEASURED_S else ": the machine is too busy, and what waits is in the agent's memory"
    print(f"{frames} pictures in {MEASURED_S:g} s{busy}")
    scale = RATE_HZ / frames
    shares = {"agent": (after["agent"].processor_s - before["agent"].processor_s) * scale}
    shares |= {name: (after[name].processor_s - before[name].processor_s) / MEASURED_S for name in ("helm", "guard")}
    return shares, {name: taken.resident_mb for name, taken in after.items()}


def _serve(swarm: FirmwareSwarm, duration_s: float) -> None:
    until_s = time.monotonic() + duration_s
    while time.monotonic() < until_s:
        swarm.serve()


def _frames(swarm: FirmwareSwarm) -> int:
    """Return how many pictures the agent has used, as it says itself."""
    swarm.until(lambda: "r1" in swarm.statuses, 10.0)
    return swarm.statuses["r1"].frames["used"]


def _taken(pid: int) -> Taken:
    """Return what /proc tells of a process (proc(5): stat fields 14 and 15, status VmRSS)."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    ticks = int(fields[11]) + int(fields[12])
    resident = next(line for line in Path(f"/proc/{pid}/status").read_text().splitlines() if line.startswith("VmRSS:"))
    return Taken(ticks / os.sysconf("SC_CLK_TCK"), int(resident.split()[1]) / 1024.0)


if __name__ == "__main__":
    sys.exit(main())
