"""How long each named step of the map server takes, over the process's life and in bounded memory."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np
from numpy.typing import NDArray

from protocol.messages import StageTimes

_EDGES_MS = np.geomspace(1e-3, 1e5, 900)  # neighbours lie 2 % apart, so a percentile is right to 1 %


class StageClock:
    """A histogram of durations for each stage."""

    def __init__(self, clock_s: Callable[[], float] = time.perf_counter) -> None:
        """Measure on `clock_s` [s]."""
        self._clock_s = clock_s
        self._counts: dict[str, NDArray[np.int64]] = {}

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Count the duration of the block as one run of the stage."""
        start_s = self._clock_s()
        yield
        duration_ms = 1e3 * (self._clock_s() - start_s)
        counts = self._counts.setdefault(name, np.zeros(len(_EDGES_MS), dtype=np.int64))
        counts[min(int(np.searchsorted(_EDGES_MS, duration_ms)), len(_EDGES_MS) - 1)] += 1

    def times(self) -> dict[str, StageTimes]:
        """Return median and 99th percentile of every stage that has run."""
        return {
            name: StageTimes(p50_ms=_percentile(counts, 0.5), p99_ms=_percentile(counts, 0.99)) for name, counts in self._counts.items()
        }


def _percentile(counts: NDArray[np.int64], share: float) -> float:
    total = np.cumsum(counts)
    return float(_EDGES_MS[np.searchsorted(total, share * total[-1])])
