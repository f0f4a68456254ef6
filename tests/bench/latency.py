"""`python -m tests.bench.latency`: how soon wheels are told what the map server has said, in a simulated swarm in real time.

The world waits for nobody. One process does nothing but listen on both buses: what counts is the time from a broadcast of setpoints on the
swarm's to the wheel command on the world's that answers its stamp, and whether the world could keep its time meanwhile.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from rich.console import Console

from deploy.coverage_meter import CoverageMeter
from deploy.formation_log import FormationLog
from deploy.recorder import Recorder
from deploy.scenario_plan import arena_arguments, plan_of
from deploy.simulation import Director, Plan, running_simulation
from deploy.unwinding import unwind_on_signals
from protocol.errors import OmmatidiaError
from protocol.messages import AgentStatus
from sim.arena import random_arena
from tests.bench.answers import answers
from tests.bench.listener import listening

BAD_USAGE = 2
AFTERWARDS_S = 10.0  # the world goes on for, so that all can be asked how they fared


def main() -> int:
    """Run the command line; return the exit code."""
    unwind_on_signals()
    parser = argparse.ArgumentParser(prog="python -m tests.bench.latency", description=__doc__)
    parser.add_argument("--seed", type=int, default=1, help="of the arena (default: %(default)s)")
    parser.add_argument("--robots", type=int, default=3, help="how many (default: %(default)s)")
    parser.add_argument("--duration", type=float, default=20.0, metavar="S", help="seconds of world time (default: %(default)s)")
    arguments = parser.parse_args()
    console = Console()
    try:
        with tempfile.TemporaryDirectory() as folder:
            sentences = measured(_plan(Path(folder), arguments.seed, arguments.robots, arguments.duration), arguments.duration)
    except OmmatidiaError as error:
        console.print(f"latency: {error}", soft_wrap=True, markup=False)
        return BAD_USAGE
    for sentence in sentences:
        console.print(sentence, soft_wrap=True, highlight=False, markup=False)
    return 0


def measured(plan: Plan, duration_s: float) -> list[str]:
    """Say how a simulation kept its time for some seconds, a line for each figure; raises OmmatidiaError where it cannot run."""
    with (
        running_simulation(plan) as simulation,
        Recorder(simulation.swarm.link, plan.folder, simulation.team.names) as recorder,
        FormationLog(plan.folder) as log,
        listening(simulation.swarm.link.endpoint, simulation.world.endpoint, simulation.team.names) as listener,
    ):
        director = Director(simulation, recorder, log, CoverageMeter(plan.area_m))
        moment = director.run(duration_s, listener)
        heard = listener.heard()
        reports, server = recorder.agent_reports(), recorder.server_report()
    found = answers(*heard)
    steps = {"map server": server.stages, **{robot: report.stages for robot, report in reports.items()}}
    return [
        f"setpoints to wheel command [ms]: p50 {found.times.p50_ms:.1f}, p99 {found.times.p99_ms:.1f}, longest {max(found.delays_ms):.1f}",
        f"setpoints: {len(found.delays_ms)} answered, {found.unanswered} not",
        f"real time over world time: {moment.wall_s / moment.world_s:.3f}",
        f"behind the world at the end: {_behind(reports, director):d} frames that the agents have had and the map server has not",
        f"frames dropped: {sum(report.frames['dropped'] for report in reports.values())}",
        *(f"{name}, one step [ms]: p50 {stages['step'].p50_ms:.1f}, p99 {stages['step'].p99_ms:.1f}" for name, stages in steps.items()),
    ]


def _behind(reports: Mapping[str, AgentStatus], director: Director) -> int:
    return max(0, sum(report.frames["used"] for report in reports.values()) - sum(director.fired.values()))


def _plan(folder: Path, seed: int, robots: int, duration_s: float) -> Plan:
    plan = plan_of(random_arena(seed, robots), arena_arguments(seed, robots), folder, duration_s + AFTERWARDS_S)
    return replace(plan, clock="real")


if __name__ == "__main__":
    sys.exit(main())
