"""Small worlds, and a camera that shows what it was asked for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from protocol.geometry import Pose2
from sim.scenario import Scenario
from sim.staging import world_of
from sim.world.cameras import Picture
from sim.world.scene import Placed, Thing
from sim.world.world import World

PERIOD_NS = 100_000_000
EXACT = {"slip_m_per_sqrt_m": 0.0, "motor_lag_s": 0.0, "command_delay_s": 0.0}


def scenario(*starts: tuple[float, float, float], truth: Mapping[str, object] = EXACT, **more: object) -> Scenario:
    """Return a scenario of robots r1, r2, ... at these starts, with exact drives if nothing else is said."""
    robots = [{"name": f"r{number}", "start": start, "truth": truth} for number, start in enumerate(starts, start=1)]
    return Scenario.model_validate({"robots": robots, **more}, strict=False)


def world(*starts: tuple[float, float, float], truth: Mapping[str, object] = EXACT, **more: object) -> World:
    """Return the world of such a scenario, its first moment shown."""
    staged = world_of(scenario(*starts, truth=truth, **more))
    staged.step()
    return staged


class TinyEye:
    """Shows a picture of 2 x 3 pixels, each time brighter, and remembers who was in it."""

    def __init__(self) -> None:
        self.level = 10
        self.seen: list[tuple[Pose2, list[str], int]] = []
        self.heights_m: list[float] = []

    def render(self, arena_from_body: Pose2, others: Sequence[Placed], people: Sequence[Thing], height_m: float = 0.0) -> Picture:
        self.level += 1
        self.heights_m.append(height_m)
        self.seen.append((arena_from_body, [placed.body.name for placed in others], len(people)))
        return np.full((2, 3, 3), self.level, dtype=np.uint8)
