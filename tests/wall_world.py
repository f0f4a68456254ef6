"""A simulated world on the wall clock, for tests of robots that know no other."""

from __future__ import annotations

from pathlib import Path

from deploy.launch import Processes
from deploy.settings_files import SITE, WORLD
from deploy.swarm import start_and_read_endpoint


def start_wall_world(processes: Processes, scenario_file: Path, told: Path) -> str:
    """Start the world of a scenario, which leaves what it hands out in `told`, and return the endpoint of its router."""
    return start_and_read_endpoint(
        processes, WORLD, "sim", "--scenario", str(scenario_file), "--site", SITE, "--clock", "wall", "--out", str(told)
    )
