"""A clock that can stand still."""

from __future__ import annotations

from deploy.stopwatch import Stopwatch


def test_a_stopwatch_counts_all_but_its_pauses() -> None:
    now_s = [100.0]
    watch = Stopwatch(lambda: now_s[0])
    now_s[0] += 2.0
    with watch.paused():
        now_s[0] += 5.0
    now_s[0] += 1.0
    assert watch.read() == 3.0
