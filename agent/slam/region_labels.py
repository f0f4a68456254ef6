"""Stable labels: a region keeps its label from frame to frame, carried by the corners that lie on it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

LAST_LABEL = 2**14 - 1  # labels begin anew after this one; a thing behind another takes the label that mirrors its front's
_LABELS = 2**15  # with those


def carry_labels(
    regions: int, region_of_corner: NDArray[np.int32], label_of_corner: NDArray[np.int32], next_label: int
) -> tuple[NDArray[np.int32], int]:
    """Return the label of each of `regions` regions, (regions,), and the next free label.

    `region_of_corner` (n,) is the region, from 1, that each followed corner now lies on, 0 for none; `label_of_corner` (n,) the label it
    had, 0 for none. A label goes to the region that most of its corners lie on; a region takes the label that most corners bring; the
    rest are new.
    """
    labels = np.zeros(regions, np.int32)
    known = (region_of_corner > 0) & (label_of_corner > 0)
    pairs, votes = np.unique((region_of_corner[known] - 1) * _LABELS + label_of_corner[known], return_counts=True)
    taken: set[int] = set()
    for pair in pairs[np.argsort(-votes, kind="stable")].tolist():
        region, label = divmod(pair, _LABELS)
        if labels[region] == 0 and label not in taken:
            labels[region] = label
            taken.add(label)
    fresh = np.flatnonzero(labels == 0)
    upcoming = (next_label - 1 + np.arange(len(fresh) + len(taken))) % LAST_LABEL + 1
    free = upcoming[~np.isin(upcoming, list(taken))][: len(fresh)]
    labels[fresh] = free
    return labels, int(free[-1]) % LAST_LABEL + 1 if len(free) else next_label
