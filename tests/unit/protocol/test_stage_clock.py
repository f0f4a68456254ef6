"""Milliseconds per stage."""

from __future__ import annotations

import pytest

from protocol.stage_clock import StageClock


class SteppedClock:
    """A clock that only moves when it is told to."""

    def __init__(self) -> None:
        self.now_s = 0.0

    def __call__(self) -> float:
        return self.now_s


def test_percentiles_are_right_to_one_percent() -> None:
    clock = StageClock()
    for duration_ms in range(1, 1001):
        clock.add("flow", duration_ms / 10.0)
    times = clock.times()["flow"]
    assert times.p50_ms == pytest.approx(50.0, rel=0.011)
    assert times.p99_ms == pytest.approx(99.0, rel=0.011)


def test_stages_may_lie_in_each_other() -> None:
    now = SteppedClock()
    clock = StageClock(now)
    with clock.stage("step"):
        now.now_s += 0.002
        with clock.stage("labels"):
            now.now_s += 0.005
    assert clock.times()["labels"].p50_ms == pytest.approx(5.0, rel=0.011)
    assert clock.times()["step"].p50_ms == pytest.approx(7.0, rel=0.011)


def test_stage_that_raises_is_counted_as_well() -> None:
    clock = StageClock()
    with pytest.raises(KeyError), clock.stage("labels"):
        raise KeyError
    assert list(clock.times()) == ["labels"]


@pytest.mark.parametrize(("duration_ms", "told_ms"), [(0.0, 0.001), (-1.0, 0.001), (1e9, 1e5)])
def test_durations_beyond_the_scale_count_at_its_ends(duration_ms: float, told_ms: float) -> None:
    clock = StageClock()
    clock.add("flow", duration_ms)
    assert clock.times()["flow"].p99_ms == pytest.approx(told_ms, rel=0.011)


def test_a_stage_that_never_ran_has_no_times() -> None:
    assert StageClock().times() == {}
