"""Rejection of misrecognised vectors within a label."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from agent.vision.rejection import Groups, RejectionLimits, consistent_vectors

LIMITS = RejectionLimits(sigmas=3.0, min_spread=0.001, min_angle_spread_rad=0.02)


def along(degrees: float, length: float = 0.05) -> list[float]:
    return [length * math.cos(math.radians(degrees)), length * math.sin(math.radians(degrees))]


def kept(vectors: list[list[float]], labels: list[int] | None = None) -> list[bool]:
    found: list[bool] = consistent_vectors(np.array(vectors), np.array(labels or [1] * len(vectors)), LIMITS).tolist()
    return found


def test_a_vector_of_twice_the_length_goes() -> None:
    assert kept([along(10, 0.050), along(10, 0.051), along(10, 0.049), along(10, 0.1)]) == [True, True, True, False]


def test_a_vector_across_goes_though_its_length_is_right() -> None:
    assert kept([along(10), along(11), along(9), along(100)]) == [True, True, True, False]


def test_angles_on_both_sides_of_180_degrees_belong_together() -> None:
    assert kept([along(179), along(-179), along(180), along(178), along(-178), along(90)]) == [True] * 5 + [False]


def test_each_label_is_judged_by_itself() -> None:
    vectors = [along(0)] * 3 + [along(90, 0.2)] * 3 + [along(90, 0.2)]
    assert kept(vectors, [1, 1, 1, 2, 2, 2, 1]) == [True] * 6 + [False]


def test_two_vectors_cannot_judge_each_other() -> None:
    assert kept([along(0), along(180)]) == [True, True]


def test_a_vector_that_is_not_finite_never_agrees() -> None:
    assert kept([along(0), along(0), along(0), [math.nan, 0.0]]) == [True, True, True, False]


def test_vectors_no_longer_than_the_noise_may_point_anywhere() -> None:
    assert all(kept([along(angle, 0.0005) for angle in (0, 70, 140, 210, 280)]))


def test_points_of_a_tall_object_whose_lengths_spread_evenly_all_stay() -> None:
    assert all(kept([along(20, length) for length in np.linspace(0.05, 0.08, 9)]))


def test_no_vectors_are_no_trouble() -> None:
    assert consistent_vectors(np.empty((0, 2)), np.empty(0, np.int32), LIMITS).shape == (0,)


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
