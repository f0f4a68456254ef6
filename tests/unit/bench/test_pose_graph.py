"""The pose graph's contest: both sides solve the same graph, and the figures tell which took longer."""

from __future__ import annotations

from tests.bench.pose_graph import measure_graph
from tests.bench.report import graph_table


def test_a_small_graph_gives_finite_times_of_both_and_their_ratio() -> None:
    contest = measure_graph(poses=100)
    assert contest.own.p50_ms > 0.0
    assert contest.bare.p50_ms > 0.0
    assert 0.1 < contest.ratio_of_sums < 10.0
    assert graph_table(contest).row_count == 5
