"""What is seen again and again, and what only flickers: reflections, and what is left of a shadow, are seldom seen twice."""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from agent.control.borders import SIGHTED
from protocol.geometry import Array

MAPS = 2  # before the newest, in one of which a thing must have been seen as well
SAME_PLACE_M = 0.03  # a border seen again is found within this

_NEIGHBOURS = np.array([(column, row) for column in (-1, 0, 1) for row in (-1, 0, 1)])


class _Past(NamedTuple):
    """One earlier local map."""

    labels: NDArray[np.int64]  # (k,)
    cells: NDArray[np.int64]  # (m,) of border points, and those around them


class Persistence:
    """Remembers the last few local maps of one robot."""

    def __init__(self) -> None:
        self._past: deque[_Past] = deque(maxlen=MAPS)

    def lasting(self, points_m: Array, labels: NDArray[np.int64], is_hidden: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Tell which of a local map's border points, (n, 2) [odom], of things with labels (n,), were there before as well.

        A thing is known again by its label or by its place, since what moves keeps no place, and what has no corners keeps no label. Where
        an outline leads under the own body, (n,), that is only concluded: it has to have been there in all of the maps. Sighted robots are
        sure at once. As long as there are too few maps, everything lasts.
        """
        cells = np.floor(points_m / SAME_PLACE_M).astype(np.int64)
        own = _numbers(cells)
        lasts = (labels == SIGHTED) | (len(self._past) < MAPS)
        always = np.ones(len(labels), dtype=np.bool_)
        for past in self._past:
            is_there = np.isin(own, past.cells)
            lasts |= ~is_hidden & (is_there | np.isin(labels, past.labels))
            always &= is_there
        lasts |= always
        around = _numbers((cells[:, None] + _NEIGHBOURS).reshape(-1, 2))
        self._past.append(_Past(np.unique(labels), np.unique(around)))
        return np.asarray(lasts)


def _numbers(cells: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return one number, (n,), for each cell (n, 2)."""
    return np.asarray(cells[:, 0] * 2**32 + cells[:, 1])
