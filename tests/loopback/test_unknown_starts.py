"""`ommatidia replay --unknown-starts` on the recording that ships here: everybody finds its place, and the run says when."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

SOON_S = 3.0
LARGEST_MEAN_ERROR_CM = 0.5
FRAMES = 50

Ommatidia = Callable[..., subprocess.CompletedProcess[str]]


@pytest.mark.slow
@pytest.mark.parametrize(("whose", "frame"), [("others", "arena"), ("all", "run, team aligned")])
def test_robots_that_are_told_no_start_join_soon_and_are_then_as_good(
    whose: str, frame: str, ommatidia: Ommatidia, excerpt: Path, tmp_path: Path
) -> None:
    run = tmp_path / "run"
    replayed = ommatidia("replay", excerpt, "--out", run, "--rate", "max", "--unknown-starts", whose)
    assert (replayed.returncode, replayed.stderr) == (0, "")
    assert ommatidia("evaluate", run, "--truth", excerpt).returncode == 0
    evaluation = json.loads((run / "evaluation.json").read_text())
    assert evaluation["frame"] == frame
    assert evaluation["paths"]["live"]["mean"]["distance_mean_cm"] < LARGEST_MEAN_ERROR_CM
    account = json.loads((run / "run.json").read_text())["robots"]
    for robot, path in evaluation["paths"]["live"]["robots"].items():
        assert path["poses_matched"] + account[robot]["unplaced"] == FRAMES
        assert (path["joined_s"] == 0.0) == (robot == "r1")
        assert path["joined_s"] < SOON_S
        assert (f"{robot} found its place after" in replayed.stdout) == (robot != "r1")
    assert "r2 has found its place" in (run / "logs" / "mapserver.log").read_text()
