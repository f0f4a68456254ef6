"""Child processes: started, watched, and always ended."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from deploy.launch import Processes, signals_held_back
from protocol.errors import LinkError

DEADLINE_S = 20.0
SLEEPS = "import time; time.sleep(600)"
IGNORES_SIGTERM = "import signal, time; signal.signal(signal.SIGTERM, signal.SIG_IGN); print('deaf', flush=True); time.sleep(600)"
FAILS = "import sys; print('starting', file=sys.stderr); sys.exit('camera: not there')"


def is_gone(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return True
    return False


def test_first_line_of_a_child_is_handed_over(tmp_path: Path) -> None:
    with Processes(tmp_path) as processes:
        line = processes.start_and_read_line("server", "-c", f"print('ready tcp/x:1', flush=True); {SLEEPS}", timeout_s=DEADLINE_S)
        assert line == "ready tcp/x:1"


def test_a_child_that_says_nothing_is_not_waited_for_for_ever(tmp_path: Path) -> None:
    with Processes(tmp_path) as processes, pytest.raises(LinkError, match=r"server was not ready within 0\.1 s"):
        processes.start_and_read_line("server", "-c", SLEEPS, timeout_s=0.1)


def test_a_child_that_fails_before_its_first_line_is_named_with_its_last_words(tmp_path: Path) -> None:
    with Processes(tmp_path) as processes, pytest.raises(LinkError, match="server ended with exit code 1: camera: not there"):
        processes.start_and_read_line("server", "-c", FAILS, timeout_s=DEADLINE_S)


def test_a_child_that_dies_is_named_while_something_else_is_waited_for(tmp_path: Path) -> None:
    def never(timeout_s: float) -> None:
        time.sleep(min(timeout_s, 0.01))
        raise LinkError("nobody came")

    with Processes(tmp_path) as processes:
        processes.start("r1", "-c", FAILS)
        with pytest.raises(LinkError, match="r1 ended with exit code 1: camera: not there"):
            processes.wait_for(never, DEADLINE_S)


def test_what_never_comes_is_reported_as_itself(tmp_path: Path) -> None:
    def never(timeout_s: float) -> None:
        raise LinkError(f"nobody came within {timeout_s:g} s")

    with Processes(tmp_path) as processes, pytest.raises(LinkError, match="nobody came within"):
        processes.wait_for(never, 0.2)


def test_both_outputs_of_a_child_go_to_its_log(tmp_path: Path) -> None:
    with Processes(tmp_path) as processes:
        processes.start("r1", "-c", "import sys; print('out', flush=True); print('err', file=sys.stderr)")
        os.waitid(os.P_PID, processes.pids["r1"], os.WEXITED | os.WNOWAIT)
    assert (tmp_path / "r1.log").read_text() == "out\nerr\n"


def test_all_children_have_ended_when_an_error_leaves_the_block(tmp_path: Path) -> None:
    pids: list[int] = []

    def fail_with_two_children() -> None:
        with Processes(tmp_path) as processes:
            processes.start("r1", "-c", SLEEPS)
            processes.start("r2", "-c", SLEEPS)
            pids.extend(processes.pids.values())
            raise RuntimeError("elsewhere")

    with pytest.raises(RuntimeError, match="elsewhere"):
        fail_with_two_children()
    assert [is_gone(pid) for pid in pids] == [True, True]


def test_a_child_that_is_deaf_to_sigterm_is_killed_within_two_seconds(tmp_path: Path) -> None:
    with Processes(tmp_path) as processes:
        processes.start_and_read_line("deaf", "-c", IGNORES_SIGTERM, timeout_s=DEADLINE_S)
        pid, started_s = processes.pids["deaf"], time.monotonic()
    assert is_gone(pid)
    assert time.monotonic() - started_s < 2.0


def test_a_childs_own_children_end_with_it(tmp_path: Path) -> None:
    parent = (
        "import signal, subprocess, sys, time\n"
        f"child = subprocess.Popen([sys.executable, '-c', {SLEEPS!r}])\n"
        "print(child.pid, flush=True)\n"
        "time.sleep(600)\n"
    )
    with Processes(tmp_path) as processes:
        grandchild = int(processes.start_and_read_line("parent", "-c", parent, timeout_s=DEADLINE_S))
    assert has_ended(grandchild)


def has_ended(pid: int) -> bool:
    """Tell whether a process is gone, or only waits for whoever inherited it to collect its exit code."""
    stat = Path(f"/proc/{pid}/stat")
    return not stat.exists() or stat.read_text().rpartition(")")[2].split()[0] in "ZX"


def test_children_compute_on_one_thread(tmp_path: Path) -> None:
    with Processes(tmp_path) as processes:
        line = processes.start_and_read_line(
            "r1", "-c", "import os; print(os.environ['OMP_NUM_THREADS'], os.environ['OPENCV_FOR_THREADS_NUM'])", timeout_s=DEADLINE_S
        )
    assert line == "1 1"


@pytest.fixture
def interruptible() -> Iterator[None]:
    """Python's own answer to Ctrl-C, which a process that a script started in the background does not have."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("interruptible")
def test_an_interrupt_takes_effect_only_when_the_child_that_is_being_started_is_known() -> None:
    known: list[str] = []

    def start_while_interrupted() -> None:
        with signals_held_back():
            signal.raise_signal(signal.SIGINT)
            known.append("r1")

    with pytest.raises(KeyboardInterrupt):
        start_while_interrupted()
    assert known == ["r1"]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
