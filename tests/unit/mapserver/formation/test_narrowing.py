"""Giving way: followers draw in before a narrow place, and speeds let them."""

from __future__ import annotations

import numpy as np
import pytest

from mapserver.formation.costmap import CostMap, cost_map
from mapserver.formation.falling_in import Spacing, backs_along, closest_along
from mapserver.formation.floor import Bounds, Floor
from mapserver.formation.narrowing import blended, lefts_along
from mapserver.formation.speeds import ACCELERATION_M_S2, speeds_along, stoppable
from mapserver.formation.trail import STEP_M, Lane
from protocol.geometry import Array
from protocol.messages import FREE, OCCUPIED

RADIUS_M = 0.075
SPACING = Spacing.of(RADIUS_M)
OFFSETS = np.array([[0.33, 0.23], [0.33, -0.23]])
TRAIL = Lane.through(np.stack([np.arange(0.2, 3.8, STEP_M), np.full(360, 1.5)], axis=1))
LEADER_M, BEGIN_M = 0.5, np.array([0.17, 0.17])  # arc lengths of the leader and of its followers at the start


def gate(gap_m: float) -> CostMap:
    """Return a map with a wall at x = 2.0 to 2.1 m whose gap lies around y = 1.5 m."""
    cells = np.full((300, 400), FREE, np.uint8)
    cells[:, 200:210] = OCCUPIED
    cells[round(150 - 50 * gap_m) : round(150 + 50 * gap_m), 200:210] = FREE
    return cost_map(Floor(cells, np.zeros(2), 0.01), Bounds(0.0, 0.0, 4.0, 3.0), TRAIL.points_m[:1], [])


def plan(gap_m: float) -> tuple[list[Lane], Array]:
    lefts_m = lefts_along(TRAIL, OFFSETS, BEGIN_M, RADIUS_M, gate(gap_m))
    lanes = [TRAIL, *(TRAIL.beside(left_m) for left_m in lefts_m)]
    return lanes, backs_along(lanes, OFFSETS[:, 0], LEADER_M, SPACING)


def test_a_wide_gate_changes_nothing() -> None:
    lanes, backs_m = plan(1.2)
    assert np.allclose(lanes[1].points_m[:, 1], 1.73)
    assert np.allclose(backs_m, 0.33)


@pytest.mark.parametrize("gap_m", [0.32, 0.4, 0.5])
def test_a_narrow_gate_makes_a_column_that_keeps_clear_of_it_and_of_itself(gap_m: float) -> None:
    lanes, backs_m = plan(gap_m)
    for lane in lanes:
        assert gate(gap_m).clearance_m(lane.points_m).min() >= RADIUS_M + 0.04
    assert closest_along(lanes, backs_m)[50:].min() >= 0.28
    assert np.allclose(backs_m[:, [55, -5]], 0.33), "open before and after"


def test_nobody_has_to_drive_backwards_or_to_turn_on_the_spot() -> None:
    lanes, backs_m = plan(0.32)
    assert np.gradient(backs_m, STEP_M, axis=1).max() <= 1.0 + 1e-9
    assert max(np.abs(lane.turns).max() for lane in lanes) < 1.0 / 0.12


def test_one_plan_goes_over_into_the_next_without_a_jump() -> None:
    old, new = np.full(100, 0.2), np.zeros(300)
    rows = blended(old, new, 0.5)
    assert np.allclose(rows[:51], 0.2)
    assert np.allclose(rows[100:], 0.0)
    assert np.abs(np.diff(rows)).max() < 0.01


def test_speeds_let_followers_keep_up_and_end_at_rest() -> None:
    lanes, backs_m = plan(0.32)
    speeds_m_s = speeds_along(lanes, backs_m, np.full(360, 0.5), 0.15, 0.22)
    pace = 1.0 - np.gradient(backs_m, STEP_M, axis=1)
    assert speeds_m_s.max() == pytest.approx(0.15)
    assert (speeds_m_s * pace).max() <= 0.22 + 1e-9
    assert speeds_m_s[-1] == 0.0


def test_every_limit_can_be_braked_to() -> None:
    speeds_m_s = stoppable(np.where(np.arange(200) == 150, 0.02, 0.2))
    assert speeds_m_s[150] == pytest.approx(0.02)
    assert (np.diff(speeds_m_s[:151] ** 2) >= -2.0 * ACCELERATION_M_S2 * STEP_M - 1e-12).all()
