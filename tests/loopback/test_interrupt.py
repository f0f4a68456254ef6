"""However a replay ends, it takes all its processes along."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

DEADLINE_S = 60.0
LIMIT_S = 2.0
CHILDREN = 10  # the map server, and an agent, its helm and its wheel guard for each of three robots

Processes = Callable[[Path], dict[int, str]]


@pytest.fixture
def replay(excerpt: Path, tmp_path: Path) -> subprocess.Popen[str]:
    """Start a replay at the recorded pace: it takes ten seconds if it is left alone."""
    command = [sys.executable, "-m", "deploy", "replay", str(excerpt), "--out", str(tmp_path / "run")]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True)


def until(condition: Callable[[], bool], replay: subprocess.Popen[str]) -> None:
    """Return when the condition holds; fail where the replay ends before, or takes too long."""
    deadline_s = time.monotonic() + DEADLINE_S
    while not condition():
        assert replay.poll() is None
        assert time.monotonic() < deadline_s
        time.sleep(0.02)


def poses_are_written(run: Path) -> bool:
    path = run / "trajectories" / "r1.tum"
    return path.is_file() and path.stat().st_size > 0


@pytest.mark.parametrize(("number", "code", "says"), [(signal.SIGINT, 130, "ommatidia: interrupted\n"), (signal.SIGTERM, 143, "")])
def test_a_signal_in_the_middle_ends_everything_within_two_seconds(
    number: signal.Signals, code: int, says: str, replay: subprocess.Popen[str], processes_of: Processes, tmp_path: Path
) -> None:
    until(lambda: poses_are_written(tmp_path / "run"), replay)
    assert len(processes_of(tmp_path / "run")) == CHILDREN
    started_s = time.monotonic()
    replay.send_signal(number)
    _, stderr = replay.communicate(timeout=DEADLINE_S)
    assert time.monotonic() - started_s < LIMIT_S
    assert (replay.returncode, stderr) == (code, says)
    assert processes_of(tmp_path / "run") == {}


def test_a_signal_while_everything_is_starting_ends_everything(
    replay: subprocess.Popen[str], processes_of: Processes, tmp_path: Path
) -> None:
    until(lambda: len(processes_of(tmp_path / "run")) >= 2, replay)
    replay.send_signal(signal.SIGINT)
    _, stderr = replay.communicate(timeout=DEADLINE_S)
    assert (replay.returncode, stderr) == (130, "ommatidia: interrupted\n")
    assert processes_of(tmp_path / "run") == {}


def test_an_agent_that_dies_is_named_and_takes_everything_with_it(
    replay: subprocess.Popen[str], processes_of: Processes, tmp_path: Path
) -> None:
    until(lambda: poses_are_written(tmp_path / "run"), replay)
    [agent] = [pid for pid, line in processes_of(tmp_path / "run").items() if "-m agent --config" in line and "r2.toml" in line]
    os.kill(agent, signal.SIGKILL)
    _, stderr = replay.communicate(timeout=DEADLINE_S)
    assert replay.returncode == 2
    assert stderr.startswith("ommatidia: r2 ended by SIGKILL: ")
    assert stderr.count("\n") == 1
    assert processes_of(tmp_path / "run") == {}
