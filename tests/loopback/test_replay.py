"""`ommatidia replay` on the recording that ships here, with real processes: what a run leaves, and that it is always the same."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

ROBOTS = ("r1", "r2", "r3")
VIEWS = ("labels", "connected", "vectors", "corrected", "hulls", "local_map")

Run = tuple[subprocess.CompletedProcess[str], Path]
Ommatidia = Callable[..., subprocess.CompletedProcess[str]]


@pytest.fixture(scope="module")
def run(ommatidia: Ommatidia, excerpt: Path, tmp_path_factory: pytest.TempPathFactory) -> Run:
    folder = tmp_path_factory.mktemp("runs") / "first"
    return ommatidia("replay", excerpt, "--out", folder, "--rate", "max"), folder


@pytest.fixture(scope="module")
def account(run: Run) -> dict[str, Any]:
    document: dict[str, Any] = json.loads((run[1] / "run.json").read_text())
    return document


def stamps(table: Path) -> list[str]:
    """Return the first column of a data.csv [ns] or a TUM file [s], all as nanoseconds."""
    lines = [line for line in table.read_text().splitlines() if line and not line.startswith("#")]
    return [line.replace(",", " ").split()[0].replace(".", "") for line in lines]


def test_the_command_succeeds_and_says_where_the_run_is(run: Run) -> None:
    result, folder = run
    assert (result.returncode, result.stderr) == (0, "")
    assert str(folder) in result.stdout


@pytest.mark.parametrize("robot", ROBOTS)
@pytest.mark.parametrize("kind", ["", "smoothed"])
def test_every_row_of_a_camera_has_its_pose(robot: str, kind: str, run: Run, excerpt: Path) -> None:
    path = run[1] / "trajectories" / kind / f"{robot}.tum"
    assert stamps(path) == stamps(excerpt / robot / "cam0" / "data.csv")


def test_a_run_leaves_all_its_files(run: Run) -> None:
    _, folder = run
    expected = ["map.geojson", "map.pgm", "map.yaml", "run.json"]
    expected += [f"pictures/{robot}_{view}{moment}.png" for robot in ROBOTS for view in VIEWS for moment in ("", "_end")]
    expected += [
        f"{place}.{kind}" for name in (*ROBOTS, "mapserver") for place, kind in ((f"config/{name}", "toml"), (f"logs/{name}", "log"))
    ]
    assert [name for name in expected if not (folder / name).is_file() or not (folder / name).stat().st_size] == []


def test_all_processes_have_ended(run: Run, processes_of: Callable[[Path], dict[int, str]]) -> None:
    assert processes_of(run[1]) == {}


def test_the_account_knows_every_frame(account: dict[str, Any]) -> None:
    assert (account["version"], account["finished"], account["method"], account["rate"]) == (1, True, "full", "max")
    for robot in ROBOTS:
        fared = account["robots"][robot]
        assert fared["frames"] == {"recorded": 50, "received": 50, "used": 50, "dropped": 0}
        assert (fared["reasons"], fared["predicted"], fared["messages_lost"]) == ({}, 0, 0)
        assert account["server"]["received"][robot] == 50


def test_a_frame_costs_no_more_than_4_kb_on_the_bus(account: dict[str, Any]) -> None:
    for robot in ROBOTS:
        size = account["robots"][robot]["bytes_per_frame"]
        assert 0 < size["median"] <= 1500
        assert size["max"] <= 4096


def test_the_account_has_milliseconds_per_stage(account: dict[str, Any]) -> None:
    for stages in (account["server"]["stages"], *(account["robots"][robot]["stages"] for robot in ROBOTS)):
        assert stages["step"]["p99_ms"] >= stages["step"]["p50_ms"] > 0.0


def test_two_runs_are_the_same_byte_for_byte(run: Run, ommatidia: Ommatidia, excerpt: Path, tmp_path: Path) -> None:
    assert ommatidia("replay", excerpt, "--out", tmp_path / "second", "--rate", "max").returncode == 0
    names = [f"trajectories/{kind}{robot}.tum" for robot in ROBOTS for kind in ("", "smoothed/")] + ["map.geojson", "map.pgm"]
    assert [name for name in names if (run[1] / name).read_bytes() != (tmp_path / "second" / name).read_bytes()] == []


def test_a_run_can_be_evaluated(run: Run, ommatidia: Ommatidia, excerpt: Path) -> None:
    result = ommatidia("evaluate", run[1], "--truth", excerpt)
    assert (result.returncode, result.stderr) == (0, "")
    assert "7.32" in result.stdout  # the paper's own path error stands beside ours
    assert (run[1] / "evaluation.json").is_file()
    assert (run[1] / "figures" / "fig18_global_map.png").is_file()


def test_an_old_run_is_not_replaced_unless_asked(run: Run, ommatidia: Ommatidia, excerpt: Path) -> None:
    before = (run[1] / "run.json").read_bytes()
    result = ommatidia("replay", excerpt, "--out", run[1])
    assert (result.returncode, result.stderr.count("\n")) == (2, 1)
    assert "--overwrite" in result.stderr
    assert (run[1] / "run.json").read_bytes() == before


@pytest.mark.slow
def test_the_recorded_pace_gives_the_same_figures(run: Run, ommatidia: Ommatidia, excerpt: Path, tmp_path: Path) -> None:
    assert ommatidia("replay", excerpt, "--out", tmp_path / "paced", "--rate", "1.0").returncode == 0
    account = json.loads((tmp_path / "paced" / "run.json").read_text())
    assert account["pace"]["wall_s"] >= account["pace"]["recorded_s"]
    for robot in ROBOTS:
        live = f"trajectories/{robot}.tum"
        assert (run[1] / live).read_bytes() == (tmp_path / "paced" / live).read_bytes()


@pytest.mark.slow
def test_the_papers_method_runs_with_both_lenses_and_both_are_judged(ommatidia: Ommatidia, excerpt: Path, tmp_path: Path) -> None:
    folder = tmp_path / "paper"
    assert ommatidia("replay", excerpt, "--out", folder, "--rate", "max", "--method", "paper").returncode == 0
    methods = [json.loads((place / "run.json").read_text())["method"] for place in (folder, folder / "calibrated_lens")]
    assert methods == ["paper", "paper-calibrated"]
    judged = ommatidia("evaluate", folder, "--truth", excerpt)
    assert judged.returncode == 0
    assert (folder / "evaluation.json").is_file()
    assert (folder / "calibrated_lens" / "evaluation.json").is_file()
