"""Where to look next: places from which the frontier is seen, where bare floor borders on what nobody has seen (Yamauchi, CIRA 1997)."""

from __future__ import annotations

import math
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import minimum_filter

from mapserver.formation.costmap import CostMap, unknown_of
from mapserver.formation.planning import COARSE, Reach
from protocol.geometry import Array, Pose2
from protocol.messages import FREE

SLIVER_CELLS = 5  # strips of unknown floor that are narrower are not worth a drive
LEAST_FRONTIER_CELLS = 3  # coarse ones
VIEW_M = 0.6  # from so far the dark is looked into
GAIN = 0.02  # of way cost that one coarse cell of frontier is worth
MOST_GAIN_CELLS = 40
TURN_COST = 0.8  # of way that it costs to turn a formation right round
BAN_M = 0.12  # around a place that stayed dark when looked at
DARK_M = 0.07  # of a line of sight that may be unknown: its end
PLACES_TRIED, FRONTIERS_TRIED = 60, 80


class Lookout(NamedTuple):
    """A place to go to, and the dark that is seen from it, each (2,) [m; arena]."""

    place_m: Array
    dark_m: Array


class Frontiers:
    """Finds lookouts, and remembers what stayed unknown although somebody went there."""

    def __init__(self) -> None:
        """Begin without experience."""
        self._banned_m: list[Array] = []

    def ban(self, lookout: Lookout) -> None:
        """Give up a place that stayed dark."""
        self._banned_m.append(lookout.dark_m)

    def best(self, cost_map: CostMap, reach: Reach, leader: Pose2) -> Lookout | None:
        """Return the lookout whose way, from `leader`, costs least for what it shows, or None where nothing more can be seen."""
        frontier = self._frontier(cost_map)
        sizes = _sizes(frontier)
        costs = np.where(_bare(cost_map), reach.costs, np.inf) + _turn_costs(cost_map, leader, frontier.shape)
        half = round(VIEW_M / (COARSE * cost_map.floor.cell_m))
        worth = minimum_filter(costs, 2 * half + 1, mode="constant", cval=np.inf) - GAIN * np.minimum(sizes, MOST_GAIN_CELLS)
        worth[sizes < LEAST_FRONTIER_CELLS] = np.inf
        promising = np.argsort(worth, axis=None)[: np.count_nonzero(np.isfinite(worth))]
        for index in promising[:: max(len(promising) // FRONTIERS_TRIED, 1)]:
            lookout = _lookout(cost_map, costs, divmod(int(index), frontier.shape[1]), half)
            if lookout is not None:
                return lookout
        return None

    def is_dark(self, cost_map: CostMap, lookout: Lookout) -> bool:
        """Tell whether a lookout still has something to show."""
        return bool(cost_map.is_unknown(lookout.dark_m))

    def _frontier(self, cost_map: CostMap) -> NDArray[np.bool_]:
        """Return the coarse cells of unknown floor that is not just a sliver, nor banned, beside bare ones."""
        unknown = unknown_of(cost_map).view(np.uint8)
        wide = cv2.morphologyEx(unknown, cv2.MORPH_OPEN, np.ones((SLIVER_CELLS, SLIVER_CELLS), np.uint8))
        middle = slice(COARSE // 2, None, COARSE)
        beside_bare = cv2.dilate(_bare(cost_map).view(np.uint8), np.ones((3, 3), np.uint8)) > 0
        frontier = (wide[middle, middle] > 0) & beside_bare
        reach = round(BAN_M / (COARSE * cost_map.floor.cell_m))
        for banned_m in self._banned_m:
            row, column = _coarse_cell(cost_map, banned_m)
            frontier[max(row - reach, 0) : row + reach + 1, max(column - reach, 0) : column + reach + 1] = False
        return frontier


def _bare(cost_map: CostMap) -> NDArray[np.bool_]:
    middle = slice(COARSE // 2, None, COARSE)
    return np.asarray(cost_map.floor.cells[middle, middle] == FREE)


def _sizes(frontier: NDArray[np.bool_]) -> Array:
    """Return for every cell how many cells the frontier has that it belongs to; 0 where there is none."""
    _, labels, statistics, _ = cv2.connectedComponentsWithStats(frontier.astype(np.uint8), connectivity=8)
    sizes = statistics[:, cv2.CC_STAT_AREA].astype(np.float64)
    sizes[0] = 0.0
    return np.asarray(sizes[labels])


def _turn_costs(cost_map: CostMap, leader: Pose2, shape: tuple[int, ...]) -> Array:
    """Return what it costs to turn towards each coarse cell."""
    rows, columns = np.indices(shape)
    x_m, y_m = _centre_m(cost_map, rows, columns).transpose(2, 0, 1) - np.array(leader[:2])[:, None, None]
    off_rad = np.arctan2(y_m, x_m) - leader.theta_rad
    return np.asarray(0.5 * TURN_COST * (1.0 - np.cos(off_rad)))


def _lookout(cost_map: CostMap, costs: Array, dark: tuple[int, int], half: int) -> Lookout | None:
    """Return the cheapest place within the box around a dark cell from which it is in sight."""
    top, left = max(dark[0] - half, 0), max(dark[1] - half, 0)
    near = costs[top : dark[0] + half + 1, left : dark[1] + half + 1]
    reached = np.argsort(near, axis=None)[: np.count_nonzero(np.isfinite(near))]
    rows, columns = np.divmod(reached[:: max(len(reached) // PLACES_TRIED, 1)], near.shape[1])
    places_m = _centre_m(cost_map, top + rows, left + columns)
    dark_m = _centre_m(cost_map, np.array(dark[0]), np.array(dark[1]))
    seeing = np.flatnonzero(_in_sight(cost_map, places_m, dark_m))
    return Lookout(places_m[seeing[0]], dark_m) if len(seeing) else None


def _in_sight(cost_map: CostMap, places_m: Array, dark_m: Array) -> NDArray[np.bool_]:
    """Tell from which places, shape (n, 2), nothing lies before the dark: neither a thing nor more dark."""
    steps = np.linspace(0.0, 1.0, math.ceil(math.sqrt(2.0) * VIEW_M / cost_map.floor.cell_m))
    lines_m = places_m[:, None] + steps[:, None] * (dark_m - places_m)[:, None]
    is_end = np.hypot(*(lines_m - dark_m).transpose(2, 0, 1)) < DARK_M
    return np.asarray(~(cost_map.is_occupied(lines_m) | (cost_map.is_unknown(lines_m) & ~is_end)).any(axis=1))


def _coarse_cell(cost_map: CostMap, place_m: Array) -> tuple[int, int]:
    column, row = np.floor((place_m - cost_map.floor.origin_m) / (COARSE * cost_map.floor.cell_m)).astype(int)
    return int(row), int(column)


def _centre_m(cost_map: CostMap, rows: NDArray[np.int_], columns: NDArray[np.int_]) -> Array:
    """Return the centres of coarse cells, shape (..., 2) [m; arena]."""
    return np.asarray(cost_map.floor.origin_m + (np.stack([columns, rows], axis=-1) + 0.5) * (COARSE * cost_map.floor.cell_m))
