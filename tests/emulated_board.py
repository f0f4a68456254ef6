"""An emulated board in a process of its own, for tests of what speaks to boards."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple


class WheelState(NamedTuple):
    """How an emulated board's wheels turn."""

    left_rad_s: float
    right_rad_s: float
    left_rad: float
    right_rad: float


class EmulatedBoard:
    """A board on a pseudo-terminal, and what can be done to it."""

    def __init__(self, process: subprocess.Popen[str], port: Path) -> None:
        self._process = process
        self.port = port

    def tell(self, order: str) -> str:
        """Have an order carried out (`sim/firmware/orders.py`) and return what the answer says; raises ValueError where it is refused."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(f"{order}\n")
        self._process.stdin.flush()
        word, _, rest = self._process.stdout.readline().strip().partition(" ")
        if word != "ok":
            raise ValueError(f"{order}: {word} {rest}")
        return rest

    def wheels(self) -> WheelState:
        """Return how the wheels turn now."""
        return WheelState(*(float(value) for value in self.tell("wheels").split()))


@contextmanager
def emulated_board(board: str, port: Path, *arguments: str) -> Iterator[EmulatedBoard]:
    """Run a board (`python -m sim.firmware BOARD --port PORT ARGUMENTS`) until the block ends."""
    command = [sys.executable, "-m", "sim.firmware", board, "--port", str(port), *arguments]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            assert process.stdout.readline().startswith("ready")
            yield EmulatedBoard(process, port)
        finally:
            process.terminate()
            process.communicate(timeout=10.0)
