"""The excerpt in poor light, on real processes: the map and the paths stay."""

from __future__ import annotations

from pathlib import Path

import pytest
from rich.console import Console

from tests.bench.frames import EXCERPT
from tests.bench.relit import LIGHTS, relit
from tests.bounds.replays import replay_figures


@pytest.mark.slow
@pytest.mark.parametrize("light", ["exposure jumps", "a fifth of the light", "60 % of the contrast"])
def test_poor_light_costs_little(light: str, tmp_path: Path) -> None:
    figures = replay_figures(relit(EXCERPT, tmp_path / "excerpt", LIGHTS[light]), tmp_path / "run", Console(quiet=True))
    assert figures["path_error_cm"] < 0.3
    assert figures["recall"] >= 0.7
    assert figures["robots_drawn"] == 0
