"""Commands that print a row for each recording."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.bench import guard_memory, robot_looks, sightings
from tests.bench.on_recordings import BAD_USAGE


@pytest.mark.parametrize("main", [guard_memory.main, robot_looks.main, sightings.main])
def test_a_folder_that_is_no_recording_gets_one_clear_line(
    main: Callable[[], int], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["bench", str(tmp_path)])
    assert main() == BAD_USAGE
    assert len(capsys.readouterr().err.splitlines()) == 1
