"""Rejection of misrecognised motion vectors: within a label, those whose magnitude or angle stands apart from the others'."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from agent.vision.groups import Groups
from protocol.geometry import Array

_FEWEST_TO_COMPARE = 3  # of two vectors nobody can say which is the wrong one


@dataclass(frozen=True)
class RejectionLimits:
    """How far a vector may stand apart from the median of its label. Lengths are in the unit of the vectors given."""

    sigmas: float = 3.0  # in robust standard deviations
    min_spread: float = 0.001  # least standard deviation of a vector, along and across its direction: measurement noise
    min_angle_spread_rad: float = 0.03  # least standard deviation of angles


def consistent_vectors(vectors: Array, labels: NDArray[np.integer], limits: RejectionLimits) -> NDArray[np.bool_]:
    """Tell which motion vectors, shape (n, 2), agree with those of the same label (n,) in magnitude and in angle; shape (n,).

    The standard deviation of either is 1.4826 times the median absolute deviation. A vector that is not finite never agrees;
    fewer than three of one label are all kept. Of vectors no longer than the noise the direction says nothing.
    """
    agrees = np.asarray(np.isfinite(vectors).all(axis=1))
    if not agrees.any():
        return agrees
    finite, of_label = vectors[agrees], Groups.of(labels[agrees])
    lengths = np.hypot(finite[:, 0], finite[:, 1])
    length = of_label.medians(lengths)
    fits = of_label.near_median(lengths, np.full_like(length, limits.min_spread), limits.sigmas)
    points = length > limits.sigmas * limits.min_spread
    noise_rad = np.maximum(limits.min_angle_spread_rad, limits.min_spread / np.where(points, length, 1.0))
    angles_rad = of_label.unrolled(np.arctan2(finite[:, 1], finite[:, 0]))
    fits &= of_label.near_median(angles_rad, noise_rad, limits.sigmas) | ~points[of_label.group]
    agrees[agrees] = fits | (of_label.sizes < _FEWEST_TO_COMPARE)[of_label.group]
    return agrees
