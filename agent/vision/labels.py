"""Labels of what is not floor: connected components, and the region connection of the paper's Algorithm 1."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from protocol.geometry import Array

Rectangles = NDArray[np.int32]  # (n, 4): x, y, width, height [px]

_NEIGHBOURS = 8


@dataclass(frozen=True, eq=False)
class Regions:
    """m labelled regions of one picture, numbered from 1 in the order of `rectangles`; label 0 is floor."""

    rectangles: Rectangles  # (m, 4)
    areas_px: NDArray[np.int64]  # (m,) pixels that are not floor
    centres_px: Array  # (m, 2) mean place of those pixels: the object centre of Eq. 8
    components: NDArray[np.int32]  # (h, w) connected components before connection; 0 is floor
    label_of_component: NDArray[np.int32]  # (components + 1,)

    def __len__(self) -> int:
        """Count the regions."""
        return len(self.rectangles)

    @cached_property
    def image(self) -> NDArray[np.int32]:
        """The label of every pixel, shape (h, w)."""
        return self.label_of_component[self.components]

    @property
    def corners_px(self) -> list[Array]:
        """The corners of every rectangle, each (4, 2)."""
        return [np.array([(x, y), (x + w, y), (x + w, y + h), (x, y + h)], float) for x, y, w, h in self.rectangles.tolist()]

    def labels_at(self, points_px: ArrayLike) -> NDArray[np.int32]:
        """Return the labels, shape (n,), at points (n, 2) [px]; 0 on the floor, outside the picture and for NaN."""
        points = np.asarray(points_px, dtype=np.float64).reshape(-1, 2)
        height, width = self.components.shape
        x, y = points.T
        inside = (x >= -0.5) & (x < width - 0.5) & (y >= -0.5) & (y < height - 0.5)
        columns, rows = np.rint(np.where(inside[:, None], points, 0.0)).astype(np.intp).T
        return np.where(inside, self.label_of_component[self.components[rows, columns]], 0).astype(np.int32)

    def mask(self, label: int) -> NDArray[np.bool_]:
        """Return where one label is, shape (height, width) of its rectangle."""
        x, y, width, height = self.rectangles[label - 1]
        return np.asarray(self.label_of_component[self.components[y : y + height, x : x + width]] == label)


def label_regions(not_floor: NDArray[np.uint8], min_area_px: int, gap_px: int = 0) -> Regions:
    """Label a mask, shape (h, w), that is 0 on the floor, and connect what belongs together (see `connect_rectangles`).

    Components of fewer than `min_area_px` pixels are taken for noise and become floor.
    """
    count, components, stats, centroids = cv2.connectedComponentsWithStatsWithAlgorithm(not_floor, _NEIGHBOURS, cv2.CV_32S, cv2.CCL_GRANA)
    kept = np.flatnonzero(stats[1:, cv2.CC_STAT_AREA] >= min_area_px) + 1
    rectangles, region = connect_rectangles(stats[kept, : cv2.CC_STAT_AREA], gap_px)
    area, centroid = stats[kept, cv2.CC_STAT_AREA].astype(np.float64), centroids[kept]
    areas, x_sums, y_sums = (
        np.bincount(region, weights=w, minlength=len(rectangles)) for w in (area, area * centroid[:, 0], area * centroid[:, 1])
    )
    label_of_component = np.zeros(count, dtype=np.int32)
    label_of_component[kept] = region + 1
    centres = np.stack([x_sums, y_sums], axis=1) / areas[:, None]
    return Regions(rectangles, areas.astype(np.int64), centres, np.asarray(components, dtype=np.int32), label_of_component)


def connect_rectangles(rectangles: ArrayLike, gap_px: int = 0) -> tuple[Rectangles, NDArray[np.intp]]:
    """Merge rectangles, shape (n, 4) [px: x, y, width, height], that overlap or contain each other, until nothing changes; Algorithm 1.

    Returns the merged rectangles (m, 4), from left to right, and for every input the row (n,) of the one that encloses it.
    Rectangles with fewer than `gap_px` empty rows or columns between them count as overlapping ("closely located" in the paper).

    The printed listing assigns the height to `width`, compares each rectangle with its successor only, and passes over the list once.
    What it means is done here: rectangles that overlap, directly or by way of others, give way to the box round them, again and again,
    until no two overlap. The result does not depend on the order of the input.
    """
    given = np.asarray(rectangles, dtype=np.int32).reshape(-1, 4)
    boxes = np.concatenate([given[:, :2], given[:, :2] + given[:, 2:]], axis=1)
    region = np.arange(len(boxes))
    while (group := _overlapping_groups(boxes, gap_px)).max(initial=-1) + 1 < len(boxes):
        boxes, region = _boxes_round(boxes, group), group[region]
    order = np.lexsort(boxes.T[::-1])
    boxes, region = boxes[order], np.argsort(order)[region]
    return np.concatenate([boxes[:, :2], boxes[:, 2:] - boxes[:, :2]], axis=1), region


def _overlapping_groups(boxes: NDArray[np.int32], gap_px: int) -> NDArray[np.intp]:
    """Return the number, shape (n,) from 0, of the group that each box (n, 4) belongs to: boxes that overlap, directly or by way of others.

    A box is left, top, right, bottom [px], the last two exclusive.
    """
    left, top, right, bottom = boxes.T
    overlap = (left < right[:, None] + gap_px) & (top < bottom[:, None] + gap_px)
    first, second = np.nonzero(overlap & overlap.T)
    starts = np.searchsorted(first, np.arange(len(boxes)))
    lowest = np.arange(len(boxes))
    while len(first) > len(boxes):  # beyond each box with itself
        spread = np.minimum.reduceat(lowest[second], starts)
        spread = spread[spread]
        if np.array_equal(spread, lowest):
            break
        lowest = spread
    return np.unique(lowest, return_inverse=True)[1]


def _boxes_round(boxes: NDArray[np.int32], group: NDArray[np.intp]) -> NDArray[np.int32]:
    """Return the boxes, shape (m, 4), that enclose the boxes (n, 4) of each group (n,)."""
    by_group = np.argsort(group, kind="stable")
    starts = np.searchsorted(group[by_group], np.arange(group.max() + 1))
    members = boxes[by_group]
    return np.concatenate([np.minimum.reduceat(members[:, :2], starts), np.maximum.reduceat(members[:, 2:], starts)], axis=1)
