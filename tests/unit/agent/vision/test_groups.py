"""Medians and angles of many small groups at once."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from agent.vision.groups import Groups


def test_angles_of_a_group_are_counted_on_across_a_whole_turn_from_its_widest_gap() -> None:
    angles_rad = np.radians([170.0, 10.0, -170.0, 160.0, -160.0, 20.0])
    unrolled = Groups.of(np.array([1, 2, 1, 1, 1, 2])).unrolled(angles_rad)
    assert np.degrees(unrolled) == pytest.approx([170.0, 370.0, 190.0, 160.0, 200.0, 380.0])


@given(st.lists(st.tuples(st.floats(-math.pi, math.pi), st.integers(0, 4)), min_size=1, max_size=30))
def test_unrolled_angles_keep_within_one_turn_and_their_direction(values: list[tuple[float, int]]) -> None:
    angles_rad, labels = np.array([angle for angle, _ in values]), np.array([label for _, label in values])
    unrolled = Groups.of(labels).unrolled(angles_rad)
    assert all(np.ptp(unrolled[labels == label]) <= 2.0 * math.pi for label in labels)
    assert np.cos(angles_rad - unrolled) == pytest.approx(np.ones(len(values)))


@given(st.lists(st.tuples(st.floats(-1.0, 1.0), st.integers(-3, 3)), min_size=1, max_size=30))
def test_medians_of_groups_are_those_of_their_values(values: list[tuple[float, int]]) -> None:
    numbers, labels = np.array([number for number, _ in values]), np.array([label for _, label in values])
    expected = [np.median(numbers[labels == label]) for label in np.unique(labels)]
    assert Groups.of(labels).medians(numbers) == pytest.approx(np.array(expected))
