"""Stage times: percentiles in bounded memory."""

from __future__ import annotations

import pytest

from mapserver.clock import StageClock


def test_percentiles_are_right_to_two_in_a_hundred() -> None:
    moments = iter([value for index in range(100) for value in (0.0, 1e-3 * (index + 1))])
    clock = StageClock(clock_s=lambda: next(moments))
    for _ in range(100):
        with clock.stage("step"):
            pass
    times = clock.times()["step"]
    assert times.p50_ms == pytest.approx(50.0, rel=0.03)
    assert times.p99_ms == pytest.approx(99.0, rel=0.03)


def test_a_stage_that_never_ran_has_no_times() -> None:
    assert StageClock().times() == {}
