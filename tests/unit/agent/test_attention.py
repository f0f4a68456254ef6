"""Stages that are timed, with something done between them."""

from __future__ import annotations

from agent.attention import AttentiveTimer
from protocol.stage_clock import StageClock


def test_something_is_done_after_each_stage_and_counts_to_none() -> None:
    now_s, done = 0.0, []
    clock = StageClock(lambda: now_s)

    def between() -> None:
        nonlocal now_s
        now_s += 100.0
        done.append(list(clock.times()))

    timer = AttentiveTimer(clock, between)
    for name in ("floor", "motion"):
        with timer.stage(name):
            now_s += 0.01
    assert done == [["floor"], ["floor", "motion"]]
    assert all(times.p99_ms < 11.0 for times in clock.times().values())
