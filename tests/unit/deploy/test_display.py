"""A replay on the terminal."""

from __future__ import annotations

import io
from pathlib import Path

import pytest
from rich.console import Console

from deploy.display import ReplayBar
from deploy.sources import CameraSource
from sim.recording import Recording


@pytest.fixture
def recording() -> CameraSource:
    return CameraSource(Recording.open(Path(__file__).parents[2] / "data" / "excerpt"), "full")


def shown(recording: CameraSource, terminal: bool) -> str:
    """Return what is printed during a replay's first step."""
    output = io.StringIO()
    with ReplayBar(recording, "full", Console(file=output, force_terminal=terminal, width=120, color_system=None)) as bar:
        bar.show(recording.steps()[0], 0.25)
    return output.getvalue()


def test_a_terminal_shows_robots_steps_speed_and_lag(recording: CameraSource) -> None:
    last_line = shown(recording, terminal=True)
    for part in ("full: r1 r2 r3", "1/50", "frames/s", "lag 0.25 s"):
        assert part in last_line


def test_nothing_is_printed_where_nobody_looks(recording: CameraSource) -> None:
    assert shown(recording, terminal=False) == ""
