"""What is promised for the recording that ships here, measured on real processes: the excerpt's own lines in the table of bounds."""

from __future__ import annotations

import pytest
from rich.console import Console

from tests.bench.frames import EXCERPT
from tests.bounds.replays import replay_figures
from tests.bounds.table import BOUNDS, Bound

PROMISED = [bound for bound in BOUNDS if bound.measurement == "excerpt"]


@pytest.fixture(scope="module")
def figures(tmp_path_factory: pytest.TempPathFactory) -> dict[str, float]:
    """Return the figures of one run."""
    return replay_figures(EXCERPT, tmp_path_factory.mktemp("excerpt") / "run", Console(quiet=True))


@pytest.mark.parametrize("bound", PROMISED, ids=lambda bound: bound.figure)
def test_the_excerpt_keeps_its_bounds(bound: Bound, figures: dict[str, float]) -> None:
    value = figures[bound.figure.removeprefix("excerpt.")]
    assert bound.holds(value), f"{bound.what}: {value:g}, not {bound.relation} {bound.limit:g} {bound.unit}"


def test_every_bound_of_a_whole_run_is_among_them() -> None:
    assert {bound.figure for bound in PROMISED} >= {f"excerpt.{name}" for name in ("path_error_cm", "recall", "invented", "robots_drawn")}
