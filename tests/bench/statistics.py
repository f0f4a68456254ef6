"""Milliseconds of named stages, every one of them kept, and what can be said of many of them."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import NamedTuple

import numpy as np

_RESAMPLES = 400
_SPREAD = (0.025, 0.975)


class Times(NamedTuple):
    """Median and 99th percentile [ms]."""

    p50_ms: float
    p99_ms: float


class Ratio(NamedTuple):
    """One median over another, with the interval that it lies in with 95 % confidence."""

    value: float
    low: float
    high: float


class Stopwatch:
    """Times named stages; as a pipeline's timer it times the pipeline's own.

    The clock is the processor time of this process, all its threads together: on an idle machine it runs as the wall clock does, and
    what other programs take does not count.
    """

    def __init__(self, clock_s: Callable[[], float] = time.process_time) -> None:
        self._clock_s = clock_s
        self.ms: dict[str, list[float]] = {}

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Time the `with` body."""
        start_s = self._clock_s()
        yield
        self.ms.setdefault(name, []).append(1e3 * (self._clock_s() - start_s))


def times(samples_ms: Sequence[float]) -> Times:
    """Return median and 99th percentile; NaN where there are no samples."""
    if not samples_ms:
        return Times(np.nan, np.nan)
    p50, p99 = np.quantile(samples_ms, [0.5, 0.99])
    return Times(float(p50), float(p99))


def ratio_of_medians(over: Sequence[float], under: Sequence[float]) -> Ratio:
    """Return the ratio for two series that were measured frame by frame side by side; the interval is found by drawing frames anew."""
    pairs = np.array([over, under])
    drawn = np.random.default_rng(0).integers(0, pairs.shape[1], (_RESAMPLES, pairs.shape[1]))
    above, below = np.median(pairs[:, drawn], axis=2)
    low, high = np.quantile(above / below, _SPREAD)
    value = np.median(pairs[0]) / np.median(pairs[1])
    return Ratio(float(value), float(low), float(high))
