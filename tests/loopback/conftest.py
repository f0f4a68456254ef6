"""The `ommatidia` command as a person runs it, and the recording that ships here, whole or spoilt."""

from __future__ import annotations

import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

COMMAND = (sys.executable, "-m", "deploy")
TIMEOUT_S = 100.0

Ommatidia = Callable[..., subprocess.CompletedProcess[str]]
Excerpt = Callable[[int], Path]


@pytest.fixture(scope="session")
def ommatidia() -> Ommatidia:
    """Return a function that runs the command with some arguments and waits for its end."""

    def run(*arguments: object) -> subprocess.CompletedProcess[str]:
        command = [*COMMAND, *(str(argument) for argument in arguments)]
        return subprocess.run(command, capture_output=True, text=True, timeout=TIMEOUT_S, check=False)

    return run


@pytest.fixture(scope="session")
def excerpt() -> Path:
    """Return the recording that ships here."""
    return Path(__file__).parents[1] / "data" / "excerpt"


@pytest.fixture
def short_excerpt(excerpt: Path, tmp_path: Path) -> Excerpt:
    """Return a function that copies the first steps of the excerpt, to be spoilt."""

    def copy(steps: int) -> Path:
        folder = tmp_path / "recording"
        shutil.copytree(excerpt, folder)
        for table in folder.glob("*/cam0/data.csv"):
            table.write_text("".join(table.read_text().splitlines(keepends=True)[: 1 + steps]))
        return folder

    return copy


@pytest.fixture(scope="session")
def processes_of() -> Callable[[Path], dict[int, str]]:
    """Return a function that finds the processes, as id and command line, whose settings lie in the folder of a run."""

    def find(folder: Path) -> dict[int, str]:
        lines = {int(process.name): _command_line(process) for process in Path("/proc").glob("[0-9]*")}
        return {pid: line for pid, line in lines.items() if f"--config {folder}/" in line}

    return find


def _command_line(process: Path) -> str:
    try:
        return (process / "cmdline").read_text().replace("\0", " ")
    except OSError:  # it has ended since it was listed
        return ""
