"""Spread in spite of a minority of wrong values."""

import numpy as np
import pytest

from agent.vision.robust import quantile, robust_sigma


def test_the_sigma_of_normal_residuals_is_theirs() -> None:
    assert robust_sigma(np.random.default_rng(1).normal(0.0, 0.3, 20_000)) == pytest.approx(0.3, rel=0.03)


def test_a_few_by_hand() -> None:
    assert robust_sigma(np.array([-2.0, 1.0, 0.5])) == pytest.approx(1.4826)
    assert robust_sigma(np.array([-2.0, 1.0])) == pytest.approx(2.0 * 1.4826)  # the upper of the middle two
    assert robust_sigma(np.zeros(4)) == 0.0


def test_wild_values_in_the_minority_do_not_count() -> None:
    residuals = np.array([0.1, -0.2, 0.3, -0.1, 0.2])
    wild = np.concatenate([residuals, [1e6, -1e6, 1e9]])
    assert robust_sigma(wild) <= 1.4826 * 0.3 + 1e-12


def test_an_offset_counts_as_spread() -> None:
    assert robust_sigma(np.full(5, 0.4)) == pytest.approx(0.4 * 1.4826)


def test_the_residuals_are_left_in_their_order() -> None:
    residuals = np.array([3.0, -1.0, 2.0])
    robust_sigma(residuals)
    assert residuals.tolist() == [3.0, -1.0, 2.0]


@pytest.mark.parametrize("share", [0.0, 0.1, 0.5, 0.9, 1.0])
@pytest.mark.parametrize("count", [1, 2, 7, 30])
def test_quantiles_are_those_of_numpy(count: int, share: float) -> None:
    values = np.random.default_rng(count).normal(size=count)
    assert quantile(values, share) == pytest.approx(np.quantile(values, share))
