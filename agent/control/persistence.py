"""Since when what a local map shows has been seen: reflections, and what is left of a shadow, only flicker."""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from protocol.geometry import Array

MAPS = 2  # before the newest, in one of which a thing must have been seen as well
SAME_PLACE_M = 0.03  # a border seen again is found within this

_NEIGHBOURS = np.array([(column, row) for column in (-1, 0, 1) for row in (-1, 0, 1)])

Numbers = NDArray[np.int64]


class _Since(NamedTuple):
    """Since when each of some numbers has been seen."""

    numbers: Numbers  # (k,) ascending
    since_ns: Numbers  # (k,)

    @classmethod
    def of(cls, numbers: Numbers, since_ns: Numbers) -> _Since:
        """Keep of each number, (n,), the earliest time."""
        order = np.argsort(since_ns, kind="stable")
        unique, first = np.unique(numbers[order], return_index=True)
        return cls(unique, since_ns[order][first])

    def earliest(self, numbers: Numbers, since_ns: Numbers) -> Numbers:
        """Return the times, (n,), or those of the same numbers, (n,), where they are earlier."""
        if not len(self.numbers):
            return since_ns
        at = np.minimum(np.searchsorted(self.numbers, numbers), len(self.numbers) - 1)
        return np.where(self.numbers[at] == numbers, np.minimum(self.since_ns[at], since_ns), since_ns)


class Persistence:
    """Remembers the last few local maps of one robot."""

    def __init__(self) -> None:
        self._past: deque[tuple[_Since, _Since]] = deque(maxlen=MAPS)  # by label, and by place

    def is_young(self) -> bool:
        """Tell whether there have been too few local maps to tell what only flickers."""
        return len(self._past) < MAPS

    def seen_since_ns(self, points_m: Array, moving: NDArray[np.bool_], labels: Numbers, stamp_ns: int) -> Numbers:
        """Return since when each of a local map's border points, (n,), has been seen: its stamp, where that is for the first time.

        The points, (n, 2) [odom], lie on things with labels (n,), some of them moving, (n,). A thing is known again by its label or by its
        place, since what moves keeps no place, and what has no corners keeps no label; where something moved nothing else is known again.
        """
        cells = np.floor(points_m / SAME_PLACE_M).astype(np.int64)
        own = _numbers(cells, moving)
        since_ns = np.full(len(labels), stamp_ns, dtype=np.int64)
        for by_label, by_place in self._past:
            since_ns = by_place.earliest(own, by_label.earliest(labels, since_ns))
        around = _numbers((cells[:, None] + _NEIGHBOURS).reshape(-1, 2), np.repeat(moving, len(_NEIGHBOURS)))
        self._past.append((_Since.of(labels, since_ns), _Since.of(around, np.repeat(since_ns, len(_NEIGHBOURS)))))
        return since_ns


def _numbers(cells: Numbers, moving: NDArray[np.bool_]) -> Numbers:
    """Return one number, (n,), for each cell (n, 2), and another for what moves there, (n,)."""
    return np.asarray((cells[:, 0] * 2**31 + cells[:, 1]) * 2 + moving)
