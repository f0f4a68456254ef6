"""`ommatidia demo`: a simulated swarm drives through a random arena, maps it, and is judged against the world's truth."""

from __future__ import annotations

from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path

from rich.console import Console

from deploy.evaluate_command import evaluate_run
from deploy.folders import default_folder, prepare_folder
from deploy.scenario_plan import arena_arguments, plan_of
from deploy.simulation import Moment, Plan, simulate
from deploy.simulation_display import SimulationBar
from protocol.errors import ConfigError
from sim.arena import random_arena
from sim.rigs import RIGS_FILE
from sim.scenario import Scenario, load_scenario, scenario_file

_MAP_PICTURE = "fig18_*.png"


@dataclass(frozen=True)
class Wishes:
    """What a person asked for; None: whatever suits."""

    robots: int
    seed: int
    duration_s: float | None
    scenario: str | None  # a file, or the name of one that ships with the world
    record: Path | None
    out: Path | None
    overwrite: bool
    headless: bool


def demo(wishes: Wishes, console: Console) -> None:
    """Run, print the evaluation's tables, and say where the picture of the map and the run are."""
    scenario, arguments = _world(wishes)
    folder = wishes.out or default_folder(Path("demo"), datetime.now())
    prepare_folder(folder, wishes.overwrite)
    plan = _plan(wishes, scenario, arguments, folder)
    console.print(f"{scenario.name}: {len(scenario.robots)} robots, {plan.duration_s:g} s at most", highlight=False)
    with SimulationBar(tuple(robot.name for robot in scenario.robots), plan.duration_s, console, wishes.headless) as bar:
        moment = simulate(plan, bar)
    evaluate_run(folder, plan.told, console)
    console.print(_outcome(moment), soft_wrap=True, highlight=False, markup=False)
    for picture in sorted((folder / "figures").glob(_MAP_PICTURE)):
        console.print(f"the map: {picture}", soft_wrap=True, highlight=False)
    console.print(f"the run: {folder}/", soft_wrap=True, highlight=False)


def _world(wishes: Wishes) -> tuple[Scenario, tuple[str, ...]]:
    """Return the scenario, and what tells the world's process to play it."""
    if wishes.scenario is None:
        return random_arena(wishes.seed, wishes.robots), arena_arguments(wishes.seed, wishes.robots)
    file = scenario_file(wishes.scenario)
    return load_scenario(file), ("--scenario", str(file.absolute()))


def _plan(wishes: Wishes, scenario: Scenario, arguments: tuple[str, ...], folder: Path) -> Plan:
    if wishes.record is not None and (wishes.record / RIGS_FILE).exists():
        raise ConfigError(f"{wishes.record}: holds a recording already; name another folder with --record")
    plan = plan_of(scenario, arguments, folder, wishes.duration_s or scenario.duration_s)
    return plan if wishes.record is None else replace(plan, told=wishes.record, record=True)


def _outcome(moment: Moment) -> str:
    """Say in one line how the run ended, and how fast the world went."""
    slower = moment.wall_s / max(moment.world_s, 1e-9)
    pace = "in real time" if slower < 1.05 else f"{slower:.1f} times slower than real time: this machine is too slow for it"
    state = moment.formation
    end = "no formation" if state is None else f"{state.phase}{f' ({state.reason})' if state.reason else ''}"
    return f"{end} after {moment.world_s:.1f} s, {pace}"
