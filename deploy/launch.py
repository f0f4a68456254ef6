"""Many processes on one machine: starts named children, notices one that dies, and ends them all on every way out."""

from __future__ import annotations

import os
import select
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Collection, Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import TracebackType
from typing import Self, TypeVar

from protocol.errors import LinkError

T = TypeVar("T")

STOP_GRACE_S = 1.4  # from the polite request to the kill; both together leave an interrupt over within 2 s
KILL_GRACE_S = 0.4  # a killed process is gone at once, unless the kernel holds it
_CHECK_PERIOD_S = 0.5
_POLL_S = 0.01
_LINE_LIMIT_BYTES = 4096
_PACKAGES = Path(__file__).resolve().parents[1]

# Every process computes on one thread: a swarm on one machine shares its cores, and sums never depend on how many there are.
_ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OPENCV_FOR_THREADS_NUM"), "1")


class Processes:
    """Named Python processes that live as long as this context; what they print goes to `logs`/<name>.log.

    Each leads a session of its own, so that Ctrl-C at the terminal reaches only the process that started them.
    """

    def __init__(self, logs: Path) -> None:
        self._logs = logs
        self._children: dict[str, subprocess.Popen[bytes]] = {}

    def __enter__(self) -> Self:
        """Make the folder for the logs."""
        self._logs.mkdir(parents=True, exist_ok=True)
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        """End all children."""
        self.stop()

    @property
    def pids(self) -> dict[str, int]:
        """The process id of every child that was started."""
        return {name: child.pid for name, child in self._children.items()}

    def start(self, name: str, *arguments: str) -> None:
        """Start `python ARGUMENTS` under this name."""
        with self._log(name).open("wb") as log:
            self._spawn(name, arguments, stdout=log.fileno(), stderr=log.fileno())

    def start_and_read_line(self, name: str, *arguments: str, timeout_s: float) -> str:
        """Start `python ARGUMENTS` under this name and return the first line it prints; LinkError where none comes in time."""
        with self._log(name).open("wb") as log:
            child = self._spawn(name, arguments, stdout=subprocess.PIPE, stderr=log.fileno())
        assert child.stdout is not None
        line = _read_line(child.stdout.fileno(), timeout_s)
        if line is None:
            raise LinkError(f"{name} was not ready within {timeout_s:g} s; see {self._log(name)}")
        if not line:
            child.wait(STOP_GRACE_S)
            self.check()
        return line

    def check(self) -> None:
        """Raise LinkError with name, exit code and last log line where a child has ended."""
        for name, child in self._children.items():
            if (code := child.poll()) is not None:
                raise LinkError(f"{name} ended {_how(code)}: {_last_line(self._log(name))} (all of it: {self._log(name)})")

    def wait_for(self, event: Callable[[float], T], timeout_s: float) -> T:
        """Call `event(seconds)`, which waits for something or raises LinkError, until it has come; a child that ends meanwhile is named."""
        deadline_s = time.monotonic() + timeout_s
        while True:
            self.check()
            left_s = deadline_s - time.monotonic()
            try:
                return event(min(max(left_s, 0.0), _CHECK_PERIOD_S))
            except LinkError:
                if left_s <= _CHECK_PERIOD_S:
                    raise

    def stop(self) -> None:
        """Ask every child and its own children to end, kill what has not ended in time, and wait for it; idempotent."""
        children, self._children = list(self._children.values()), {}
        _signal(children, signal.SIGTERM)
        _wait_until_gone(children, STOP_GRACE_S)
        _signal(children, signal.SIGKILL)
        _wait_until_gone(children, KILL_GRACE_S)
        for child in children:
            if child.stdout is not None:
                child.stdout.close()

    def _log(self, name: str) -> Path:
        return self._logs / f"{name}.log"

    def _spawn(self, name: str, arguments: Iterable[str], stdout: int, stderr: int) -> subprocess.Popen[bytes]:
        """Start a child in the folder that holds our packages, so that a folder of the user's cannot stand in for one of them."""
        with signals_held_back():
            self._children[name] = subprocess.Popen(
                [sys.executable, *arguments],
                stdin=subprocess.DEVNULL,
                stdout=stdout,
                stderr=stderr,
                cwd=_PACKAGES,
                env={**os.environ, **_ONE_THREAD},
                start_new_session=True,
            )
        return self._children[name]


@contextmanager
def signals_held_back() -> Iterator[None]:
    """Let SIGINT and SIGTERM take effect after the block: between a child's start and its registration they would leave it behind."""
    held: list[int] = []
    handlers = {number: signal.signal(number, lambda number, _: held.append(number)) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)
        for arrived in held:
            signal.raise_signal(arrived)


def _read_line(pipe: int, timeout_s: float) -> str | None:
    """Return the first line from a pipe: empty where the other end closed before, None where time ran out."""
    deadline_s = time.monotonic() + timeout_s
    data = b""
    while b"\n" not in data and len(data) < _LINE_LIMIT_BYTES:
        readable, _, _ = select.select([pipe], [], [], max(0.0, deadline_s - time.monotonic()))
        if not readable:
            return None
        piece = os.read(pipe, _LINE_LIMIT_BYTES)
        if not piece:
            return ""
        data += piece
    return data.split(b"\n")[0].decode("utf-8", errors="replace")


def _signal(children: Iterable[subprocess.Popen[bytes]], number: signal.Signals) -> None:
    for child in children:
        with suppress(ProcessLookupError):
            os.killpg(child.pid, number)


def _wait_until_gone(children: Collection[subprocess.Popen[bytes]], timeout_s: float) -> None:
    """Return when no process of any child's session is left, or when time has run out."""
    deadline_s = time.monotonic() + timeout_s
    while any(_session_lives(child) for child in children) and time.monotonic() < deadline_s:
        time.sleep(_POLL_S)


def _session_lives(child: subprocess.Popen[bytes]) -> bool:
    child.poll()  # collects its exit code, without which it would stay in its session as a zombie
    try:
        os.killpg(child.pid, 0)
    except ProcessLookupError:
        return False
    return True


def _how(code: int) -> str:
    return f"by {signal.Signals(-code).name}" if code < 0 else f"with exit code {code}"


def _last_line(log: Path) -> str:
    lines = log.read_text(encoding="utf-8", errors="replace").split("\n")
    return next((line.strip() for line in reversed(lines) if line.strip()), "it said nothing")
