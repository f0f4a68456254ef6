"""A clock that can stand still: what the recorder does for itself must not count as the swarm's time."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager


class Stopwatch:
    """Seconds since it was made, without the pauses."""

    def __init__(self, clock_s: Callable[[], float] = time.monotonic) -> None:
        self._clock_s = clock_s
        self._zero_s = clock_s()

    def read(self) -> float:
        """Return the seconds so far."""
        return self._clock_s() - self._zero_s

    @contextmanager
    def paused(self) -> Iterator[None]:
        """Stand still during the block."""
        before_s = self.read()
        yield
        self._zero_s = self._clock_s() - before_s
