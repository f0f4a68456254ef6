"""The ground truth of a simulated world, as a recording keeps it, for scoring only: it grows with every moment.

* ground_truth/scenario.toml     the scenario, whole
* ground_truth/world.json        what stands on the floor
* ground_truth/<robot>.tum       timestamp[s] x y z qx qy qz qw, at every moment, arena frame
* ground_truth/collisions.csv    #timestamp [ns],robot,other
"""

from __future__ import annotations

import json
import math
from contextlib import ExitStack
from pathlib import Path
from typing import Self

import tomli_w

from protocol.geometry import Pose2
from sim.scenario import ArenaTable, Scenario
from sim.staging import obstacles_of
from sim.world.scene import Thing
from sim.world.world import Moment

FOLDER = "ground_truth"

_TUM_HEADER = "# timestamp[s] x y z qx qy qz qw  (body frame in arena frame)\n"


class GroundTruth:
    """Writes down the truth. Use it as a context manager."""

    def __init__(self, scenario: Scenario, out: Path) -> None:
        """Write what does not change, and begin the tables; raises OSError where that cannot be."""
        folder = out / FOLDER
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "scenario.toml").write_text(tomli_w.dumps(scenario.model_dump(mode="json", exclude_none=True)), encoding="utf-8")
        (folder / "world.json").write_text(json.dumps(world_document(scenario)), encoding="utf-8")
        with ExitStack() as opening:
            names = [robot.name for robot in scenario.robots]
            self._paths = {name: opening.enter_context((folder / f"{name}.tum").open("w", encoding="utf-8", buffering=1)) for name in names}
            self._collisions = opening.enter_context((folder / "collisions.csv").open("w", encoding="utf-8", buffering=1))
            for path in self._paths.values():
                path.write(_TUM_HEADER)
            self._collisions.write("#timestamp [ns],robot,other\n")
            self._open = opening.pop_all()

    def add(self, moment: Moment) -> None:
        """Write down a moment; every line is in its file when this returns."""
        for placed in moment.robots:
            self._paths[placed.body.name].write(tum_line(moment.stamp_ns, placed.arena_from_body))
        for collision in moment.collisions:
            self._collisions.write(f"{collision.stamp_ns},{collision.robot},{collision.other}\n")

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._open.close()


def tum_line(stamp_ns: int, arena_from_body: Pose2) -> str:
    """Return a pose as a line of a TUM file."""
    x_m, y_m, theta_rad = arena_from_body
    seconds = f"{stamp_ns // 10**9}.{stamp_ns % 10**9:09d}"
    return f"{seconds} {x_m:.6f} {y_m:.6f} 0.000000 0.000000000 0.000000000 {math.sin(theta_rad / 2):.9f} {math.cos(theta_rad / 2):.9f}\n"


def world_document(scenario: Scenario) -> dict[str, object]:
    """Return world.json: what stands inside the walls."""
    arena = scenario.arena
    return {
        "frame": "arena",
        "units": "m",
        "floor_variant": arena.floor,
        "arena_bounds": _bounds(arena),
        "obstacles": [_obstacle(number, thing) for number, thing in enumerate(obstacles_of(scenario))],
    }


def _bounds(arena: ArenaTable) -> list[list[float]]:
    low, high = (arena.x_min_m, arena.y_min_m), (arena.x_max_m, arena.y_max_m)
    return [[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]]]


def _obstacle(number: int, thing: Thing) -> dict[str, object]:
    return {
        "id": number,
        "kind": thing.kind,
        "material": thing.material,
        "height": thing.height_m,
        "footprint": thing.footprint_m.round(5).tolist(),
        "centre": thing.footprint_m.mean(axis=0).tolist(),
    }
