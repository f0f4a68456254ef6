"""One random arena, driven in lockstep by real processes, and judged by the world's truth."""

from __future__ import annotations

import csv
import json
import math
from dataclasses import asdict, dataclass, replace
from pathlib import Path

from deploy.evaluation.evaluate import Evaluation, evaluate
from deploy.folders import prepare_folder
from deploy.scenario_plan import arena_arguments, plan_of
from deploy.simulation import Display, Moment, simulate
from protocol.messages import FormationState
from sim.arena import random_arena
from sim.scenario import Scenario

NEAR_GOAL_M = 0.05
MOST_S = 180.0  # of world time: who is not there by then is stuck


@dataclass(frozen=True)
class ArenaResult:
    """What came of one arena; lengths in centimetres, NaN: not measured."""

    seed: int
    robots: int
    reached: bool
    world_s: float
    wall_s: float
    collisions: int
    path_cm: float
    steady_cm: float
    avoiding_cm: float
    restored_s: float  # the longest; NaN: the formation never gave way
    recall: float
    invented: int
    ending: str  # the formation's last phase, and its reason

    def write(self, folder: Path) -> None:
        """Leave the result beside the run."""
        (folder / "result.json").write_text(json.dumps(asdict(self), indent=1) + "\n", encoding="utf-8")


def run_arena(seed: int, robots: int, folder: Path, display: Display, most_s: float = MOST_S) -> ArenaResult:
    """Drive through the arena, leave the run in its folder, and return the result; raises OmmatidiaError where that cannot go on."""
    scenario = random_arena(seed, robots)
    moment, told = driven(scenario, arena_arguments(seed, robots), folder, display, most_s)
    result = _result(seed, robots, moment, evaluate(folder, told), collisions_in(told), scenario.goals_m[-1])
    result.write(folder)
    return result


def driven(scenario: Scenario, world: tuple[str, ...], folder: Path, display: Display, most_s: float) -> tuple[Moment, Path]:
    """Drive as fast as it goes, leave the run in its folder, and return how things stood at its end, and where the world left its truth.

    `world` is what tells the world about the scenario on its command line.
    """
    prepare_folder(folder, overwrite=True)
    plan = replace(plan_of(scenario, world, folder, most_s), pace=math.inf)
    return simulate(plan, display), plan.told


def _result(seed: int, robots: int, moment: Moment, evaluation: Evaluation, collisions: int, goal_m: tuple[float, float]) -> ArenaResult:
    state, formation = moment.formation, evaluation.formation
    nan = math.nan
    return ArenaResult(
        seed=seed,
        robots=robots,
        reached=_reached(moment, goal_m),
        world_s=moment.world_s,
        wall_s=moment.wall_s,
        collisions=collisions,
        path_cm=100.0 * evaluation.live.mean.distance_m.mean,
        steady_cm=100.0 * formation.steady_rms_m if formation else nan,
        avoiding_cm=100.0 * formation.avoiding_rms_m if formation else nan,
        restored_s=max(formation.restored_s, default=nan) if formation else nan,
        recall=evaluation.map.recall,
        invented=len(evaluation.map.invented),
        ending=ending_of(state),
    )


def ending_of(state: FormationState | None) -> str:
    """Return a formation's phase and its reason in one line; empty where nobody heard of it."""
    return "" if state is None else " ".join(filter(None, (state.phase, state.reason)))


def _reached(moment: Moment, goal_m: tuple[float, float]) -> bool:
    """Tell whether the formation says that it has arrived, and whoever leads it truly stands there."""
    state, truth = moment.formation, moment.truth
    if state is None or truth is None or state.phase != "arrived":
        return False
    places = {body.robot: body.arena_from_body[:2] for body in truth.bodies}
    return min(math.dist(place, goal_m) for place in places.values()) < NEAR_GOAL_M


def collisions_in(told: Path) -> int:
    """Return how many collisions the world has written down in its folder."""
    with (told / "ground_truth" / "collisions.csv").open(encoding="utf-8", newline="") as file:
        return sum(1 for row in csv.reader(file) if row and not row[0].startswith("#"))
