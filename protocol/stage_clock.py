"""How long each named stage takes, over the process's whole life, in bounded memory."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np
from numpy.typing import NDArray

from protocol.messages import StageTimes

_SHORTEST_MS = 1e-3
_BINS_PER_DECADE = 115  # each bin is 2 % wider than the one before, so that a percentile is right to 1 %
_DECADES = 8  # up to 100 s; what lasts longer counts as that


class StageClock:
    """Keeps a histogram of milliseconds for every stage, on a logarithmic scale."""

    def __init__(self, clock_s: Callable[[], float] = time.perf_counter) -> None:
        self._clock_s = clock_s
        self._histograms: dict[str, NDArray[np.int64]] = {}

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Count the time of the `with` body as one run of the stage, also where it raises."""
        start_s = self._clock_s()
        try:
            yield
        finally:
            self.add(name, 1e3 * (self._clock_s() - start_s))

    def add(self, name: str, duration_ms: float) -> None:
        """Count one run of a stage."""
        if name not in self._histograms:
            self._histograms[name] = np.zeros(_BINS_PER_DECADE * _DECADES, dtype=np.int64)
        self._histograms[name][_bin_of(duration_ms)] += 1

    def times(self) -> dict[str, StageTimes]:
        """Return the median and the 99th percentile of every stage that has run, in the order in which they first ended."""
        return {
            name: StageTimes(p50_ms=_percentile(histogram, 0.50), p99_ms=_percentile(histogram, 0.99))
            for name, histogram in self._histograms.items()
        }


def _bin_of(duration_ms: float) -> int:
    decades = math.log10(max(duration_ms, _SHORTEST_MS) / _SHORTEST_MS)
    return min(int(decades * _BINS_PER_DECADE), _BINS_PER_DECADE * _DECADES - 1)


def _percentile(histogram: NDArray[np.int64], share: float) -> float:
    """Return the middle [ms] of the first bin up to which at least `share` of the runs lie."""
    runs = np.cumsum(histogram)
    index = int(np.searchsorted(runs, math.ceil(share * runs[-1])))
    return float(_SHORTEST_MS * 10.0 ** ((index + 0.5) / _BINS_PER_DECADE))
