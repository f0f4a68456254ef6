"""Attention to something else between two stages of a long step: a robot that looks must not stop listening."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from agent.pipeline import StageTimer


class AttentiveTimer:
    """Times stages by another timer, and does something short after each of them, which counts to none."""

    def __init__(self, timer: StageTimer, between: Callable[[], None]) -> None:
        self._timer, self._between = timer, between

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Time what happens inside."""
        with self._timer.stage(name):
            yield
        self._between()
