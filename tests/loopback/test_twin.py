"""The simulator is no kinder than the world: a recording and its simulated twin are followed about as well, on real processes."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import pytest
from rich.console import Console

from tests.bench.frames import EXCERPT
from tests.bench.twin_command import BAD_USAGE, compare, figures_of_both, is_alike, path_ratio

Both = tuple[Mapping[str, float], Mapping[str, float]]


@pytest.fixture(scope="module")
def both(tmp_path_factory: pytest.TempPathFactory) -> Both:
    """Return the figures of the excerpt and of its twin."""
    return figures_of_both(EXCERPT, tmp_path_factory.mktemp("twin"), 1, Console(quiet=True))


@pytest.mark.slow
@pytest.mark.timeout(300)
def test_the_excerpt_s_twin_has_its_path_error_within_a_factor_of_two(both: Both) -> None:
    assert is_alike(path_ratio(*both)), f"{path_ratio(*both):.2f}"


@pytest.mark.slow
@pytest.mark.timeout(300)
def test_the_twin_loses_no_pose_and_draws_no_robot(both: Both) -> None:
    _, twin = both
    assert (twin["missing_poses"], twin["robots_drawn"]) == (0, 0)


@pytest.mark.parametrize(("ratio", "alike"), [(0.49, False), (0.5, True), (1.0, True), (2.0, True), (2.1, False), (float("nan"), False)])
def test_alike_is_within_a_factor_of_two_either_way(ratio: float, *, alike: bool) -> None:
    assert is_alike(ratio) == alike


def test_a_recording_that_cannot_be_used_is_said_in_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert compare(tmp_path / "nowhere", tmp_path / "out", 1) == BAD_USAGE
    [line] = capsys.readouterr().err.splitlines()
    assert line == f"twin: {tmp_path}/nowhere: no such folder; give the folder that holds robots.yaml"
