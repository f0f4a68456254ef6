"""What each part of the method is worth, on the recording that ships here."""

from __future__ import annotations

from pathlib import Path

import cv2
import pytest
from rich.console import Console

from deploy.ablation import ablation, variants
from deploy.evaluate_command import evaluate_run
from protocol.errors import ConfigError
from tests.bench.frames import EXCERPT
from tests.mrclam_folder import write_folder


@pytest.mark.slow
@pytest.mark.timeout(360)
def test_every_part_makes_the_paths_truer_or_leaves_them_as_true() -> None:
    cv2.setNumThreads(1)
    done: dict[str, float] = {}
    rows = ablation(EXCERPT, done.__setitem__)
    error_m = {name: team.mean.distance_m.mean for name, team in rows.items()}
    assert list(rows) == [row.name for row in variants()]
    assert set(done.values()) == {1.0}
    assert error_m["floor motion only"] < 0.5 * error_m["wheels only"]
    assert error_m["plus landmarks"] < 1.05 * error_m["floor motion only"]
    assert error_m["plus other robots"] < 0.5 * error_m["floor motion only"]
    assert error_m["plus objects"] < 1.1 * error_m["plus other robots"]
    assert error_m["plus self-calibration"] < 1.2 * error_m["plus other robots"]
    assert error_m["the paper's method"] > 10.0 * error_m["plus self-calibration"]


def test_a_folder_without_cameras_is_refused_in_one_line(tmp_path: Path) -> None:
    folder = write_folder(tmp_path / "set")
    with pytest.raises(ConfigError, match="--ablation"):
        evaluate_run(tmp_path / "run", folder, Console(quiet=True), ablates=True)
