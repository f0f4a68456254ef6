"""Whole swarms in a simulated world, in lockstep: real processes drive in formation through random arenas."""

from __future__ import annotations

from pathlib import Path

import pytest

from deploy.simulation import Moment
from tests.soak.arenas import run_arena

DRIVE_S = 12.0
LEAST_WAY_M = 0.15


class Watch:
    """Keeps how things stood first and last, and which phases the formation went through."""

    def __init__(self) -> None:
        self.phases: set[str] = set()
        self.x_m: dict[str, list[float]] = {}

    def show(self, moment: Moment) -> None:
        if moment.formation is not None:
            self.phases.add(moment.formation.phase)
        for body in moment.truth.bodies if moment.truth else ():
            self.x_m.setdefault(body.robot, []).append(body.arena_from_body[0])


@pytest.mark.slow
@pytest.mark.timeout(400)
@pytest.mark.parametrize("seed", [2, 3])
def test_three_robots_drive_in_formation_and_touch_nothing(seed: int, tmp_path: Path) -> None:
    watch = Watch()
    result = run_arena(seed, 3, tmp_path, watch, DRIVE_S)
    assert result.collisions == 0
    assert result.path_cm < 1.5
    assert "avoiding" in watch.phases
    assert max(max(path) - min(path) for path in watch.x_m.values()) > LEAST_WAY_M
