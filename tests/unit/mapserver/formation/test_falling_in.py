"""Falling in: whoever would meet somebody on the way waits, and catches up again."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mapserver.formation.falling_in import FASTEST_PACE, Spacing, backs_along, closest_along, column_backs
from mapserver.formation.trail import STEP_M, Lane
from protocol.geometry import Array

SPACING = Spacing.of(0.075)
STRAIGHT = Lane.through(np.stack([np.arange(0.0, 4.0, STEP_M), np.full(400, 1.5)], axis=1))
OPEN_M = np.array([0.33, 0.33])
LEADER_M = 0.5


def drawn_in_from(arc_m: float, until_m: float) -> list[Lane]:
    """Return the lanes of a wedge that is a column between two arc lengths."""
    arcs_m = STEP_M * np.arange(400)
    lefts_m = 0.23 * np.clip(np.abs(arcs_m - 0.5 * (arc_m + until_m)) / (0.25 * (until_m - arc_m)) - 1.0, 0.0, 1.0)
    return [STRAIGHT, STRAIGHT.beside(lefts_m), STRAIGHT.beside(-lefts_m)]


def hairpin(radius_m: float) -> Lane:
    """Return a trail that turns about."""
    bend = np.arange(0.0, np.pi, STEP_M / radius_m)
    there = np.stack([np.arange(0.0, 1.5, STEP_M), np.zeros(150)], axis=1)
    about = np.stack([1.5 + radius_m * np.sin(bend), radius_m * (1.0 - np.cos(bend))], axis=1)
    back = np.stack([np.arange(1.5, 0.0, -STEP_M), np.full(150, 2.0 * radius_m)], axis=1)
    return Lane.through(np.vstack([there, about, back]))


def pace(backs_m: Array) -> Array:
    return 1.0 - np.diff(backs_m, axis=1) / STEP_M


def test_one_waits_for_the_other_where_their_lanes_meet_and_catches_up() -> None:
    lanes = drawn_in_from(1.5, 2.5)
    backs_m = backs_along(lanes, OPEN_M, LEADER_M, SPACING)
    assert closest_along(lanes, backs_m)[50:].min() > SPACING.least_m - 0.02
    assert np.allclose(backs_m[0], 0.33, atol=0.02), "the first has no need to wait"
    assert backs_m[1].max() > 0.6
    assert np.allclose(backs_m[:, [60, -1]], 0.33, atol=1e-3)


@pytest.mark.parametrize("radius_m", [0.12, 0.17, 0.3])
def test_nobody_comes_near_on_a_trail_that_turns_about(radius_m: float) -> None:
    lanes = [hairpin(radius_m)] * 4
    backs_m = backs_along(lanes, np.array([0.33, 0.66, 0.99]), 1.1, SPACING)
    assert closest_along(lanes, backs_m)[115:].min() > min(SPACING.least_m, 2.0 * radius_m) - 0.03


def test_nobody_goes_back_or_rushes() -> None:
    paces = pace(backs_along(drawn_in_from(1.5, 2.1), OPEN_M, LEADER_M, SPACING))
    assert paces.min() >= -1e-9
    assert paces.max() <= FASTEST_PACE + 1e-9


def test_a_new_plan_begins_where_followers_are_and_how_they_move() -> None:
    held_m = np.array([np.full(400, 0.4), np.full(400, 0.7)])
    backs_m = backs_along(drawn_in_from(1.5, 2.5), OPEN_M, 1.0, SPACING, held_m)
    assert np.allclose(backs_m[:, 100], [0.4, 0.7], atol=1e-6)
    assert np.abs(pace(backs_m)[:, 100] - 1.0).max() < 0.2
    assert pace(backs_m).min() >= -1e-9


def test_robots_that_stand_too_near_part_by_one_of_them_waiting() -> None:
    held_m = np.full((1, 400), 0.25)
    backs_m = backs_along([STRAIGHT, STRAIGHT], np.array([0.33]), 1.0, SPACING, held_m)
    closest_m = closest_along([STRAIGHT, STRAIGHT], backs_m)
    assert closest_m[100:].min() > 0.24
    assert closest_m[-1] == pytest.approx(0.33, abs=1e-3)


@given(st.lists(st.floats(0.0, 2.0), min_size=1, max_size=8).map(sorted))
def test_a_column_keeps_its_spacing_and_order(backs: list[float]) -> None:
    column_m = column_backs(np.array(backs), 0.32)
    assert column_m[0] >= 0.32 - 1e-9
    assert (np.diff(column_m) >= 0.32 - 1e-9).all()


def test_a_column_that_is_one_stays_as_it_is() -> None:
    assert column_backs(np.array([0.4, 0.8, 1.3]), 0.32).tolist() == pytest.approx([0.4, 0.8, 1.3])
