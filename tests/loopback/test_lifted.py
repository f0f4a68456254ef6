"""A robot alone in its arena is lifted while it drives, and put down elsewhere: it finds itself by the floor, and drives on to its goal."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import pytest

from deploy.folders import prepare_folder
from deploy.scenario_plan import plan_of
from deploy.simulation import Moment, simulate
from sim.scenario import load_scenario

GOAL_M, PUT_DOWN_M = (0.1, 0.0), (-0.9, 0.3)
MOST_S = 25.0
SCENARIO = f"""\
goals_m = [[{GOAL_M[0]}, {GOAL_M[1]}]]
[camera]
rate_hz = 5.0
[arena]
x_max_m = 0.8
[[robots]]
name = "r1"
start = [-1.0, 0.0, 0.0]
[[faults]]
robot = "r1"
kind = "lifted"
from_s = 5.0
until_s = 6.0
to = [{PUT_DOWN_M[0]}, {PUT_DOWN_M[1]}, 2.5]
"""


class Watch:
    """Keeps where the robot truly was."""

    def __init__(self) -> None:
        self.places_m: list[tuple[float, float]] = []

    def show(self, moment: Moment) -> None:
        for body in moment.truth.bodies if moment.truth else ():
            self.places_m.append(body.arena_from_body[:2])


@pytest.mark.timeout(120)
def test_a_robot_that_is_put_down_elsewhere_finds_itself_by_the_floor_and_drives_on(tmp_path: Path) -> None:
    file, run, watch = tmp_path / "lifted.toml", tmp_path / "run", Watch()
    file.write_text(SCENARIO, encoding="utf-8")
    prepare_folder(run, overwrite=True)
    plan = replace(plan_of(load_scenario(file), ("--scenario", str(file)), run, MOST_S), pace=math.inf)
    last = simulate(plan, watch)
    assert last.formation is not None
    assert last.formation.phase == "arrived"
    assert math.dist(watch.places_m[-1], GOAL_M) < 0.03
    assert min(math.dist(place_m, PUT_DOWN_M) for place_m in watch.places_m) < 0.01
    assert "r1 was put down elsewhere" in (run / "logs" / "r1.log").read_text(encoding="utf-8")
