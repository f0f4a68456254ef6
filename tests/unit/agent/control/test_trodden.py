"""Where robots have been."""

from __future__ import annotations

import numpy as np

from agent.control.trodden import SURELY_M, TRODDEN_S, Trodden

RADIUS_M = 0.075
EDGE_M = RADIUS_M - SURELY_M


def test_a_robot_has_trodden_what_its_body_surely_covered() -> None:
    trodden = Trodden(RADIUS_M)
    assert not trodden.holds(np.zeros((1, 2))).any()
    for step in range(11):
        trodden.note(100_000_000 * step, {"r2": np.array([0.1 * step, 0.0])})
    points = np.array([(0.5, 0.0), (0.5, EDGE_M - 0.001), (0.5, EDGE_M + 0.001), (-EDGE_M - 0.001, 0.0)])
    assert trodden.holds(points).tolist() == [True, True, False, False]


def test_what_was_trodden_long_ago_tells_nothing() -> None:
    trodden = Trodden(RADIUS_M)
    trodden.note(0, {"r2": np.zeros(2)})
    trodden.note(round(1e9 * TRODDEN_S), {"r2": np.ones(2)})
    assert trodden.holds(np.zeros((1, 2))).all()
    trodden.note(round(1e9 * TRODDEN_S) + 1, {"r2": np.ones(2)})
    assert not trodden.holds(np.zeros((1, 2))).any()


def test_a_robot_that_stands_still_fills_no_memory_and_is_not_forgotten() -> None:
    trodden = Trodden(RADIUS_M)
    for second in range(100):
        trodden.note(second * 1_000_000_000, {"r2": np.zeros(2), "r3": np.ones(2)})
    assert trodden.holds(np.array([(0.0, 0.0), (1.0, 1.0)])).all()
