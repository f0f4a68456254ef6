"""How a further process of a robot is started."""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import Any

import pytest

from agent.clocks.local_clock import LocalClock
from agent.driving.child import Child


def test_a_child_finds_the_robots_own_packages_first(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    started_in: list[Path] = []

    def popen(command: list[str], *, cwd: Path, **_: Any) -> None:
        started_in.append(cwd)

    monkeypatch.setattr(subprocess, "Popen", popen)
    Child.start("helm", "agent.driving.helm", tmp_path / "agent.toml", LocalClock()).pipe.close()
    (folder,) = started_in
    assert (folder / "agent" / "driving" / "helm.py").is_file()
