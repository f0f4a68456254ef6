"""Spread of values that holds in spite of a minority of wrong ones."""

from __future__ import annotations

import numpy as np

from protocol.geometry import Array

_SIGMA_PER_MAD = 1.4826  # of a normal distribution


def robust_sigma(residuals: Array) -> float:
    """Return the standard deviation of residuals (n,) around zero, n > 0, by the median of their magnitudes.

    The upper median is taken, which costs a third of numpy's and is the same but for a rank.
    """
    magnitudes = np.abs(residuals)
    middle = magnitudes.size // 2
    return _SIGMA_PER_MAD * float(np.partition(magnitudes, middle)[middle])
