"""The noise of the pose graph's factors: what a measurement may be wrong by, and that it may be wrong altogether."""

from __future__ import annotations

import gtsam
import numpy as np

from mapserver.mapping.belief import Twist
from protocol.geometry import Array

CAUCHY_SCALE = 2.0  # whitened residual at which what may be wrong altogether loses half its weight


def motion_within(gap_s: float, twist: Twist | None, range_m: float) -> Array:
    """Return the covariance of (range, bearing), shape (2, 2), that a target adds by driving on for `gap_s`."""
    if twist is None:
        return np.zeros((2, 2))
    speed_m_s = float(np.hypot(*twist.body_from_next[:2])) / twist.duration_s
    variance = (speed_m_s * gap_s) ** 2
    return np.diag([variance, variance / range_m**2])


def robust_sighting(covariance: Array) -> gtsam.noiseModel.Robust:
    """Return the noise of a sighting with this covariance of (range, bearing), shape (2, 2); GTSAM's order is (bearing, range)."""
    return robust(covariance[::-1, ::-1])


def robust(covariance: Array) -> gtsam.noiseModel.Robust:
    """Return the noise of what may be wrong altogether, with this covariance where it is not."""
    loss = gtsam.noiseModel.mEstimator.Cauchy.Create(CAUCHY_SCALE)
    return gtsam.noiseModel.Robust.Create(loss, gtsam.noiseModel.Gaussian.Covariance(covariance))
