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


@dataclass(frozen=True, eq=False)
class Groups:
    """Which of n values belong together: all groups are judged at once, since there are many, and few values in each."""

    group: NDArray[np.intp]  # (n,) from 0
    sizes: NDArray[np.intp]  # (groups,) none of them 0
    firsts: NDArray[np.intp]  # (groups,) where each would begin if values were sorted by group

    @classmethod
    def of(cls, labels: NDArray[np.integer]) -> Groups:
        """Return the groups of equal labels, (n,)."""
        _, group, sizes = np.unique(labels, return_inverse=True, return_counts=True)
        return cls(group, sizes, np.cumsum(sizes) - sizes)

    def medians(self, values: Array) -> Array:
        """Return the median of each group's values, (n,), shape (groups,)."""
        ascending = values[np.lexsort((values, self.group))]
        return 0.5 * (ascending[self.firsts + (self.sizes - 1) // 2] + ascending[self.firsts + self.sizes // 2])

    def near_median(self, values: Array, least_spread: Array, sigmas: float) -> NDArray[np.bool_]:
        """Tell which values, (n,), lie within so many robust standard deviations, `least_spread` (groups,) at least, of the median."""
        off = np.abs(values - self.medians(values)[self.group])
        reach = sigmas * np.maximum(_SIGMA_PER_MAD * self.medians(off), least_spread)
        return np.asarray(off <= reach[self.group])

    def unrolled(self, angles_rad: Array) -> Array:
        """Return angles, (n,), without a jump within a group: those before its widest gap are counted on from those after it."""
        ascending = angles_rad[np.lexsort((angles_rad, self.group))]
        lasts = self.firsts + self.sizes - 1
        following = np.append(ascending[1:], 0.0)
        following[lasts] = ascending[self.firsts] + 2.0 * np.pi
        gaps = following - ascending
        is_widest = gaps == np.repeat(np.maximum.reduceat(gaps, self.firsts), self.sizes)
        before_gap = np.minimum.reduceat(np.where(is_widest, ascending, np.inf), self.firsts)
        return np.where(angles_rad <= before_gap[self.group], angles_rad + 2.0 * np.pi, angles_rad)
