"""Rejection of misrecognised vectors within a label."""

import math

import numpy as np

from agent.vision.rejection import RejectionLimits, consistent_vectors

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
