"""How a scenario is simulated: its world, the formation that it asks for, and where the run is left."""

from __future__ import annotations

from pathlib import Path

from deploy.simulation import Plan
from sim.arena_robots import WEDGE_ANGLE_RAD, WEDGE_SPACING_M
from sim.scenario import Scenario

WORLD_FOLDER = "world"


def plan_of(scenario: Scenario, world: tuple[str, ...], folder: Path, duration_s: float) -> Plan:
    """Return the plan to simulate a scenario in lockstep, no faster than real time, for so long at most and without a recording.

    `world` is what tells the world's process, on its command line, to play the scenario.
    """
    arena = scenario.arena
    area_m = (arena.x_min_m, arena.y_min_m, arena.x_max_m, arena.y_max_m)
    goals = [list(goal) for goal in scenario.goals_m]
    return Plan(
        folder=folder,
        told=folder / WORLD_FOLDER,
        area_m=area_m,
        world=world,
        formation={
            "kind": "wedge" if goals else "explore",
            "distance_m": WEDGE_SPACING_M,
            "angle_rad": WEDGE_ANGLE_RAD,
            "goals": goals,
            "bounds": list(area_m),
        },
        clock="lockstep",
        pace=1.0,
        duration_s=duration_s,
        record=False,
    )


def arena_arguments(seed: int, robots: int) -> tuple[str, ...]:
    """Return what tells the world's process to play a random arena."""
    return "--seed", str(seed), "--robots", str(robots)
