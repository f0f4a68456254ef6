"""Whole swarms in a simulated world, in lockstep: real processes drive in formation through random arenas."""

from __future__ import annotations

from pathlib import Path

import pytest

from deploy.simulation import Moment
from tests.soak.arenas import run_arena

LEAST_WAY_M = 2.0


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
@pytest.mark.parametrize("seed", [5, 8])
def test_three_robots_drive_through_an_arena_in_formation_and_map_it(seed: int, tmp_path: Path) -> None:
    watch = Watch()
    result = run_arena(seed, 3, tmp_path, watch)
    assert result.reached, result.ending
    assert result.collisions == 0
    assert result.path_cm < 1.5
    assert result.avoiding_cm < 6.0
    assert result.recall >= 0.8
    assert "avoiding" in watch.phases
    assert max(max(path) - min(path) for path in watch.x_m.values()) > LEAST_WAY_M
