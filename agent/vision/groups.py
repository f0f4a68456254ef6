"""Values that belong together: medians of all groups at once, since there are many groups and few values in each."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from agent.vision.robust import SIGMA_PER_MAD
from protocol.geometry import Array


@dataclass(frozen=True, eq=False)
class Groups:
    """Which of n values belong together."""

    labels: NDArray[np.integer]  # (groups,) ascending
    group: NDArray[np.intp]  # (n,) the place of each value's label in `labels`
    sizes: NDArray[np.intp]  # (groups,) none of them 0
    firsts: NDArray[np.intp]  # (groups,) where each begins when values are sorted by group

    @classmethod
    def of(cls, labels: NDArray[np.integer]) -> Groups:
        """Return the groups of equal labels, (n,)."""
        names, group, sizes = np.unique(labels, return_inverse=True, return_counts=True)
        return cls(names, group, sizes, np.cumsum(sizes) - sizes)

    def medians(self, values: Array) -> Array:
        """Return the median of each group's values, (n,), shape (groups,)."""
        ascending = values[np.lexsort((values, self.group))]
        return np.asarray(0.5 * (ascending[self.firsts + (self.sizes - 1) // 2] + ascending[self.firsts + self.sizes // 2]))

    def near_median(self, values: Array, least_spread: Array, sigmas: float) -> NDArray[np.bool_]:
        """Tell which values, (n,), lie within so many robust standard deviations, `least_spread` (groups,) at least, of the median."""
        off = np.abs(values - self.medians(values)[self.group])
        reach = sigmas * np.maximum(SIGMA_PER_MAD * self.medians(off), least_spread)
        return np.asarray(off <= reach[self.group])

    def unrolled(self, angles_rad: Array) -> Array:
        """Return angles, (n,), without a jump within a group: those before its widest gap are counted on from those after it."""
        ascending = angles_rad[np.lexsort((angles_rad, self.group))]
        following = np.append(ascending[1:], 0.0)
        following[self.firsts + self.sizes - 1] = ascending[self.firsts] + 2.0 * np.pi
        gaps = following - ascending
        is_widest = gaps == np.repeat(np.maximum.reduceat(gaps, self.firsts), self.sizes)
        before_gap = np.minimum.reduceat(np.where(is_widest, ascending, np.inf), self.firsts)
        return np.where(angles_rad <= before_gap[self.group], angles_rad + 2.0 * np.pi, angles_rad)
