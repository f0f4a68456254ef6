"""Ends a command by unwinding it, so that every child process is ended on the way, whether a person or a service manager asks."""

from __future__ import annotations

import signal
from types import FrameType

INTERRUPTED, TERMINATED = 130, 143  # exit codes


def unwind_on_signals() -> None:
    """Let SIGINT raise KeyboardInterrupt and SIGTERM raise SystemExit, once; a second signal must not disturb what that begins."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, _unwind)


def _unwind(number: int, frame: FrameType | None) -> None:
    for each in (signal.SIGINT, signal.SIGTERM):
        signal.signal(each, signal.SIG_IGN)
    if number == signal.SIGTERM:
        raise SystemExit(TERMINATED)
    raise KeyboardInterrupt
