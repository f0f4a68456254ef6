"""`ommatidia replay` on spoilt recordings: what can be dropped is counted and the run goes on, the rest is one clear line."""

from __future__ import annotations

import json
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest

STEPS = 8

Ommatidia = Callable[..., subprocess.CompletedProcess[str]]
Excerpt = Callable[[int], Path]


def pictures(recording: Path, robot: str) -> list[Path]:
    """Return the pictures of a robot in the order of its data.csv."""
    rows = (recording / robot / "cam0" / "data.csv").read_text().splitlines()[1:]
    return [recording / robot / "cam0" / "data" / row.split(",")[1].strip() for row in rows]


def keep_lines(table: Path, count: int) -> None:
    table.write_text("".join(table.read_text().splitlines(keepends=True)[:count]))


def refused(result: subprocess.CompletedProcess[str]) -> str:
    """Return the one line that a command says which ends with exit code 2."""
    assert (result.returncode, result.stderr.count("\n")) == (2, 1)
    return result.stderr


def test_unusable_pictures_and_missing_wheel_data_are_counted_and_the_run_goes_on(
    short_excerpt: Excerpt, ommatidia: Ommatidia, tmp_path: Path
) -> None:
    recording, run = short_excerpt(STEPS), tmp_path / "run"
    pictures(recording, "r1")[2].unlink()
    truncated = pictures(recording, "r2")[3]
    truncated.write_bytes(truncated.read_bytes()[:1000])
    cv2.imwrite(str(pictures(recording, "r3")[4]), np.zeros((48, 64, 3), dtype=np.uint8))
    keep_lines(recording / "r2" / "wheels0" / "data.csv", 30)
    shutil.rmtree(recording / "ground_truth")

    result = ommatidia("replay", recording, "--out", run, "--rate", "max")
    assert (result.returncode, result.stderr) == (0, "")
    account = json.loads((run / "run.json").read_text())
    for robot, reason in (("r1", "picture: missing"), ("r2", "picture: undecodable"), ("r3", "picture: wrong size")):
        fared = account["robots"][robot]
        assert fared["frames"] == {"recorded": STEPS, "received": STEPS, "used": STEPS - 1, "dropped": 1}
        assert fared["reasons"][reason] == 1
        assert (run / "trajectories" / f"{robot}.tum").read_text().count("\n") == STEPS
    assert any("r1/cam0/data.csv" in warning for warning in account["warnings"])
    assert any("r2/wheels0/data.csv" in warning for warning in account["warnings"])
    assert any("wheel" in reason for reason in account["robots"]["r2"]["reasons"])
    assert "ground_truth" in refused(ommatidia("evaluate", run, "--truth", recording))


def test_a_calibration_with_nan_is_refused(short_excerpt: Excerpt, ommatidia: Ommatidia, tmp_path: Path) -> None:
    recording = short_excerpt(STEPS)
    sensor = recording / "r2" / "cam0" / "sensor.yaml"
    sensor.write_text(sensor.read_text().replace("fov_deg: ", "fov_deg: .nan # "))
    line = refused(ommatidia("replay", recording, "--out", tmp_path / "run"))
    assert f"{sensor}: `fov_deg`" in line


def test_timestamps_that_run_backwards_are_refused(short_excerpt: Excerpt, ommatidia: Ommatidia, tmp_path: Path) -> None:
    recording = short_excerpt(STEPS)
    table = recording / "r1" / "cam0" / "data.csv"
    head, *rows = table.read_text().splitlines(keepends=True)
    table.write_text("".join([head, *reversed(rows)]))
    line = refused(ommatidia("replay", recording, "--out", tmp_path / "run"))
    assert "r1/cam0/data.csv, line 3, timestamp [ns]" in line


@pytest.mark.parametrize("field", ["wheel_base_m", "name"])
def test_a_missing_field_of_a_robot_is_named(field: str, short_excerpt: Excerpt, ommatidia: Ommatidia, tmp_path: Path) -> None:
    recording = short_excerpt(STEPS)
    rigs = recording / "robots.yaml"
    rigs.write_text(rigs.read_text().replace(f" {field}:", f" no_{field}:"))
    assert f"robots[0].{field}" in refused(ommatidia("replay", recording, "--out", tmp_path / "run"))
