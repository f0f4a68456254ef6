"""What is said of many milliseconds."""

from __future__ import annotations

import math

import pytest

from tests.bench.statistics import Stopwatch, ratio_of_medians, times


def test_a_stage_is_timed_by_the_clock_that_is_passed_in() -> None:
    readings = iter([1.0, 1.002, 5.0, 5.004])
    watch = Stopwatch(lambda: next(readings))
    for _ in range(2):
        with watch.stage("work"):
            pass
    assert watch.ms == {"work": pytest.approx([2.0, 4.0])}


def test_times_are_median_and_99th_percentile() -> None:
    assert times([float(value) for value in range(101)]) == (50.0, 99.0)
    assert all(map(math.isnan, times([])))


def test_a_ratio_of_medians_lies_within_its_interval() -> None:
    slow, fast = [4.0, 5.0, 6.0, 5.0, 40.0], [2.0, 2.5, 3.0, 2.5, 2.5]
    ratio = ratio_of_medians(slow, fast)
    assert ratio.value == 2.0
    assert ratio.low <= ratio.value <= ratio.high


def test_series_that_go_together_have_a_narrow_interval() -> None:
    under = [1.0, 2.0, 3.0, 4.0, 5.0]
    assert ratio_of_medians([3.0 * value for value in under], under) == pytest.approx((3.0, 3.0, 3.0))
