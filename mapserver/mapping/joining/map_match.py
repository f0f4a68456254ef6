"""How well what a robot sees from a supposed pose fits the map: base lines on base lines, and none where the map has bare floor.

A likelihood field: Thrun, Burgard, Fox, "Probabilistic Robotics", 2005, ch. 6.4, with one value a thing, since its points err together.
"""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from mapserver.mapping.floor.grid import CELL_M, Cells
from protocol.geometry import Array
from protocol.messages import FREE, OCCUPIED, LocalMap, Region

REACH_M = 1.2  # base lines are not told well beyond
STEP_M = 0.01  # between points of an outline
BIN_RAD = 0.03  # of direction; of an outline's points in it the nearest lies on the base line
LEAST_POINTS = 4  # of a base line
FIELD_SIGMA_M = 0.03  # of a base line on the map, with what a pose may be wrong by
ON_BASE_NATS, ON_BARE_NATS = 2.0, -1.2  # for a thing all on mapped base lines; all on floor that the map has bare: it may be new, or none
CHANCE_POSES, CHANCE_M = 64, 0.5  # poses by chance: so many, so far around


class BaseLines(NamedTuple):
    """Points on the base lines of all standing things in one view."""

    points_m: Array  # (n, 2) [m; body]
    things: NDArray[np.intp]  # (n,) to which thing each belongs, from 0


class MapField:
    """What a base line is worth in each place of the map."""

    def __init__(self, cells: Cells, origin_m: Array) -> None:
        """Take the map's cells, (rows, columns), and its lowest corner, (2,) [m; arena]."""
        self._origin_m = origin_m
        occupied = cells == OCCUPIED
        edges = occupied & (cv2.erode(occupied.astype(np.uint8), np.ones((3, 3), np.uint8)) == 0)
        distances_m = cv2.distanceTransform((~edges).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE) * CELL_M
        nearness = np.exp(-0.5 * (distances_m / FIELD_SIGMA_M) ** 2) if edges.any() else np.zeros(cells.shape)
        known = (cells == FREE) | occupied
        self._nats = np.where(known, ON_BARE_NATS + (ON_BASE_NATS - ON_BARE_NATS) * nearness, 0.0)

    def nats_at(self, points_m: Array) -> Array:
        """Return what points, (..., 2) [m; arena], of a base line are worth, (...); 0 where the map tells nothing."""
        columns, rows = np.moveaxis(np.floor((points_m - self._origin_m) / CELL_M).astype(np.int64), -1, 0)
        height, width = self._nats.shape
        within = (rows >= 0) & (rows < height) & (columns >= 0) & (columns < width)
        return np.where(within, self._nats[np.clip(rows, 0, height - 1), np.clip(columns, 0, width - 1)], 0.0)


def base_lines(local_map: LocalMap) -> BaseLines:
    """Return the base lines of all standing things in reach."""
    lines = [_near_border(region) for region in local_map.regions if region.motion != "moving"]
    lines = [line for line in lines if len(line) >= LEAST_POINTS]
    things = np.repeat(np.arange(len(lines), dtype=np.intp), [len(line) for line in lines])
    return BaseLines(np.concatenate([np.empty((0, 2)), *lines]), things)


def match_nats(lines: BaseLines, poses: Array, field: MapField) -> Array:
    """Return what speaks for poses arena_from_body, (h, 3): how much likelier they make the view than poses around, by chance."""
    if not len(lines.things):
        return np.zeros(len(poses))
    by_chance = _by_chance(poses[0])
    return _fit_nats(lines, poses, field) - float(np.log(np.mean(np.exp(_fit_nats(lines, by_chance, field)))))


def _fit_nats(lines: BaseLines, poses: Array, field: MapField) -> Array:
    """Return for each pose the sum over things of the mean over the points of their base lines, (h,)."""
    turn = np.exp(1j * poses[:, 2])[:, None] * (lines.points_m @ (1.0, 1.0j))
    nats = field.nats_at(np.stack([poses[:, :1] + turn.real, poses[:, 1:2] + turn.imag], axis=-1))
    weights = 1.0 / np.bincount(lines.things)[lines.things]
    return np.asarray(nats @ weights)


def _by_chance(pose: Array) -> Array:
    """Return poses around one, (CHANCE_POSES, 3), in any direction; always the same ones."""
    random = np.random.default_rng(0)
    places = pose[:2] + random.uniform(-CHANCE_M, CHANCE_M, (CHANCE_POSES, 2))
    return np.column_stack([places, random.uniform(-np.pi, np.pi, CHANCE_POSES)])


def _near_border(region: Region) -> Array:
    """Return the points, (n, 2) [m; body], of an outline that are the nearest in their direction, as far as they are in reach."""
    points_m = _dense(region.outline.metres())
    ranges_m = np.hypot(*points_m.T)
    bins = np.floor(np.arctan2(points_m[:, 1], points_m[:, 0]) / BIN_RAD).astype(np.int64)
    order = np.lexsort((ranges_m, bins))
    nearest = order[np.flatnonzero(np.diff(bins[order], prepend=bins.min() - 1))]
    return np.asarray(points_m[nearest[ranges_m[nearest] < REACH_M]])


def _dense(outline_m: Array) -> Array:
    """Return a closed outline, (n, 2) [m], with a point every `STEP_M` or less."""
    parts = []
    for start, end in zip(outline_m, np.roll(outline_m, -1, axis=0), strict=True):
        steps = max(1, int(np.ceil(np.hypot(*(end - start)) / STEP_M)))
        parts.append(start + np.linspace(0.0, 1.0, steps, endpoint=False)[:, None] * (end - start))
    return np.concatenate(parts)
