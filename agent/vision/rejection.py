"""Rejection of misrecognised motion vectors: within a label, those whose magnitude or angle stands apart from the others'."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from protocol.geometry import Array

_SIGMA_PER_MAD = 1.4826  # of a normal distribution
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
    fewer than three of one label are all kept.
    """
    agrees = np.asarray(np.isfinite(vectors).all(axis=1))
    for label in np.unique(labels[agrees]):
        members = np.flatnonzero(agrees & (labels == label))
        if len(members) >= _FEWEST_TO_COMPARE:
            agrees[members] = _agree_with_median(vectors[members], limits)
    return agrees


def sort_by_angle(vectors: Array) -> tuple[NDArray[np.intp], Array]:
    """Return the order, shape (n,), of vectors (n, 2), n > 0, by angle, and the angles [rad] so sorted, without a jump at +-pi.

    The order begins after the widest gap between neighbouring angles, so that what points the same way stays together.
    """
    angles = np.arctan2(vectors[:, 1], vectors[:, 0])
    order = np.argsort(angles, kind="stable")
    ascending = angles[order]
    gaps = np.diff(ascending, append=ascending[:1] + 2.0 * np.pi)
    first = (int(np.argmax(gaps)) + 1) % len(order)
    unrolled = np.concatenate([ascending[first:], ascending[:first] + 2.0 * np.pi])
    return np.roll(order, -first), unrolled


def _agree_with_median(vectors: Array, limits: RejectionLimits) -> NDArray[np.bool_]:
    """Tell which vectors, shape (n, 2), are near the median in magnitude and in angle; shape (n,)."""
    magnitudes = np.hypot(vectors[:, 0], vectors[:, 1])
    magnitude = _median(magnitudes)
    fits: NDArray[np.bool_] = np.abs(magnitudes - magnitude) <= limits.sigmas * _spread(magnitudes, limits.min_spread)
    if magnitude <= limits.sigmas * limits.min_spread:  # no longer than the noise: the direction says nothing
        return fits
    order, angles = sort_by_angle(vectors)
    noise_rad = max(limits.min_angle_spread_rad, limits.min_spread / magnitude)
    fits[order] &= np.abs(angles - _median(angles)) <= limits.sigmas * _spread(angles, noise_rad)
    return fits


def _spread(values: Array, least: float) -> float:
    """Return the robust standard deviation of values (n,), at least `least`."""
    return max(_SIGMA_PER_MAD * _median(np.abs(values - _median(values))), least)


def _median(values: Array) -> float:
    """Return the median of values (n,), n > 0; on a handful of them much faster than numpy's."""
    ascending = np.sort(values)
    return 0.5 * float(ascending[(len(values) - 1) // 2] + ascending[len(values) // 2])
