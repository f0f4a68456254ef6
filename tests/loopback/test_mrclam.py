"""`ommatidia replay --format mrclam`, with real processes: a small folder written for the test, and the real data where they are here."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.mrclam_folder import STARTS, write_folder

Ommatidia = Callable[..., subprocess.CompletedProcess[str]]
ROBOTS = tuple(f"r{number}" for number in STARTS)
SHARE = 0.2
COMMAND = (sys.executable, "-m", "deploy")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_folder(tmp_path_factory.mktemp("data") / "mrclam", duration_s=30.0)


@pytest.fixture(scope="module")
def run(ommatidia: Ommatidia, folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return replayed(ommatidia, folder, tmp_path_factory.mktemp("runs") / "whole")


@pytest.fixture(scope="module")
def lossy(ommatidia: Ommatidia, folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return replayed(ommatidia, folder, tmp_path_factory.mktemp("runs") / "lossy", "--loss", SHARE, "--seed", 3)


def replayed(ommatidia: Ommatidia, folder: Path, out: Path, *more: object) -> Path:
    result = ommatidia("replay", "--format", "mrclam", folder, "--out", out, "--rate", "max", *more)
    assert (result.returncode, result.stderr) == (0, "")
    return out


def account(run: Path) -> dict[str, Any]:
    document: dict[str, Any] = json.loads((run / "run.json").read_text())
    return document


def judged(ommatidia: Ommatidia, run: Path, folder: Path) -> dict[str, Any]:
    result = ommatidia("evaluate", run, "--truth", folder)
    assert (result.returncode, result.stderr) == (0, "")
    assert "team" in result.stdout
    document: dict[str, Any] = json.loads((run / "evaluation.json").read_text())
    return document


def test_every_local_map_reaches_the_map_server(run: Path) -> None:
    told = account(run)
    assert (told["finished"], told["method"]) == (True, "mrclam")
    for robot in ROBOTS:
        frames = told["robots"][robot]["frames"]
        assert frames["recorded"] == frames["received"] == told["server"]["received"][robot] == 60
        assert told["robots"][robot]["messages_lost"] == 0


def test_robots_whose_start_nobody_told_find_their_place(run: Path) -> None:
    for robot in ROBOTS:
        live = (run / "trajectories" / f"{robot}.tum").read_text().splitlines()
        smoothed = (run / "trajectories" / "smoothed" / f"{robot}.tum").read_text().splitlines()
        assert len(smoothed) == 60
        assert 50 <= len(live) <= 60


def test_the_team_is_judged_after_one_alignment(ommatidia: Ommatidia, run: Path, folder: Path) -> None:
    document = judged(ommatidia, run, folder)
    assert document["live"]["team_rmse_m"] < 0.05
    assert document["smoothed"]["team_rmse_m"] < 0.03
    assert document["live"]["largest_robot_rmse_m"] == max(robot["rmse_m"] for robot in document["live"]["robots"].values())


def test_messages_are_lost_both_ways_and_the_run_goes_on(ommatidia: Ommatidia, lossy: Path, folder: Path) -> None:
    told = account(lossy)
    lost = sum(60 - told["server"]["received"][robot] for robot in ROBOTS)
    assert told["server"]["refused"] == {"lost as asked": lost}
    assert 15 <= lost <= 60
    assert all(told["robots"][robot]["predicted"] > 5 for robot in ROBOTS)
    assert judged(ommatidia, lossy, folder)["live"]["team_rmse_m"] < 0.07


def test_the_same_seed_loses_the_same(ommatidia: Ommatidia, lossy: Path, folder: Path, tmp_path: Path) -> None:
    again = replayed(ommatidia, folder, tmp_path / "again", "--loss", SHARE, "--seed", 3)
    for robot in ROBOTS:
        path = Path("trajectories", f"{robot}.tum")
        assert (again / path).read_text() == (lossy / path).read_text()


def test_a_folder_of_another_kind_is_one_line(ommatidia: Ommatidia, excerpt: Path) -> None:
    result = ommatidia("replay", "--format", "mrclam", excerpt)
    assert result.returncode == 2
    assert "holds no Barcodes.dat" in result.stderr
    assert result.stderr.count("\n") == 1


def test_what_is_for_cameras_alone_is_refused(ommatidia: Ommatidia, folder: Path) -> None:
    result = ommatidia("replay", "--format", "mrclam", folder, "--method", "paper")
    assert result.returncode == 2
    assert "--method and --unknown-starts are for recordings of cameras" in result.stderr


def test_a_recording_of_cameras_goes_on_with_losses(ommatidia: Ommatidia, excerpt: Path, tmp_path: Path) -> None:
    result = ommatidia("replay", excerpt, "--out", tmp_path / "run", "--rate", "max", "--loss", SHARE, "--seed", 1)
    assert result.returncode == 0
    told = account(tmp_path / "run")
    for robot in ("r1", "r2", "r3"):
        assert told["server"]["received"][robot] < 50
        assert told["robots"][robot]["predicted"] > 0


@pytest.fixture(scope="module")
def real(shared: Path) -> Path:
    folder = shared / "real" / "mrclam" / "dataset6"
    if not folder.is_dir():
        pytest.skip("the UTIAS data are not here: no folder real/mrclam/dataset6 in the folder of big recordings")
    return folder


@pytest.mark.slow
@pytest.mark.timeout(400)
def test_real_robots_are_tracked_within_their_bounds_also_where_messages_are_lost(real: Path, tmp_path: Path) -> None:
    figures = []
    for name, more in (("whole", ()), ("lossy", ("--loss", "0.2", "--seed", "1"))):
        out = tmp_path / name
        replay = ("replay", "--format", "mrclam", str(real), "--out", str(out), "--rate", "max", *more)
        for arguments in (replay, ("evaluate", str(out), "--truth", str(real))):
            subprocess.run((*COMMAND, *arguments), capture_output=True, check=True, timeout=190.0)
        figures.append(json.loads((out / "evaluation.json").read_text()))
    whole, lossy = figures
    assert whole["live"]["team_rmse_m"] <= 0.13
    assert whole["smoothed"]["team_rmse_m"] <= 0.10
    assert lossy["live"]["team_rmse_m"] <= 1.15 * whole["live"]["team_rmse_m"]
