"""The cheapest way over the mapped floor for a round body: Dijkstra on coarse cells, which prefers the middle of gaps and what is known."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from mapserver.formation.costmap import CostMap, unknown_of
from protocol.geometry import Array

COARSE = 3  # cells of the map along one cell of the plan
NARROW_COST = 5.0  # a metre where a body just fits through costs so much more than one with the wished clearance
UNKNOWN_COST = 1.5
ESCAPE_M, ESCAPE_COST = 0.15, 20.0  # so near to the start even a place too tight for planning is left, at this cost a metre
NEAR_GOAL_M = 0.25  # a goal too near to a thing is replaced by a free place so near to it


class Berth(NamedTuple):
    """How far a body's centre keeps from things [m]: never nearer than `least`, and rather `wished`."""

    least_m: float
    wished_m: float
    unknown_cost: float = UNKNOWN_COST  # a metre that nobody has seen costs so much more than one that is bare


class Reach:
    """The cheapest ways from one place to all others."""

    def __init__(self, cost_map: CostMap, start_m: Array, berth: Berth) -> None:
        """Plan from `start_m`, shape (2,) [m; arena]."""
        self._origin_m = cost_map.floor.origin_m
        self._cell_m = COARSE * cost_map.floor.cell_m
        costs = _costs(cost_map, berth)
        self._shape = costs.shape
        _open_start(costs, self._centres_m(), start_m, cost_map)
        found = dijkstra(_graph(costs), indices=np.array([self._index(start_m)]), return_predecessors=True)
        self._start_m = start_m
        self.costs: Array = (
            found[0][0].reshape(self._shape) * self._cell_m
        )  # of the way to every coarse cell, shape (rows, columns); inf: none
        self._before: NDArray[np.int32] = found[1][0]

    def route(self, goal_m: Array) -> Array | None:
        """Return the way to a goal, shape (n, 2) [m; arena], or None; it may end in a free place near to it."""
        end = self._nearest_reached(goal_m)
        if end is None:
            return None
        cells = [end]
        while (before := int(self._before[cells[-1]])) >= 0:
            cells.append(before)
        way_m = self._centres_m().reshape(-1, 2)[cells[::-1]]
        last_m = goal_m if self._index(goal_m) == end else way_m[-1]
        return np.vstack([self._start_m, way_m[1:-1], last_m])

    def routes_of_cost(self, cost: float, count: int) -> list[Array]:
        """Return about `count` ways that cost so much, or a little more, to places all around, shape (n, 2) [m; arena] each."""
        cells = np.flatnonzero((self.costs >= cost) & (self.costs < cost + 2.0 * self._cell_m))
        chosen = cells[:: max(len(cells) // count, 1)]
        ways = [self.route(centre_m) for centre_m in self._centres_m().reshape(-1, 2)[chosen]]
        return [way_m for way_m in ways if way_m is not None]

    def cost_to(self, place_m: Array) -> float:
        """Return the cost of the way to a place, infinite where there is none."""
        return float(self.costs.reshape(-1)[self._index(place_m)])

    def _nearest_reached(self, goal_m: Array) -> int | None:
        away_m = np.hypot(*(self._centres_m() - goal_m).transpose(2, 0, 1))
        away_m[~np.isfinite(self.costs)] = np.inf
        nearest = int(np.argmin(away_m))
        return nearest if away_m.reshape(-1)[nearest] <= NEAR_GOAL_M else None

    def _index(self, place_m: Array) -> int:
        column, row = np.floor((place_m - self._origin_m) / self._cell_m).astype(int)
        rows, columns = self._shape
        return int(np.clip(row, 0, rows - 1) * columns + np.clip(column, 0, columns - 1))

    def _centres_m(self) -> Array:
        """Return every coarse cell's centre, shape (rows, columns, 2)."""
        rows, columns = self._shape
        x_m, y_m = ((np.arange(count) + 0.5) * self._cell_m for count in (columns, rows))
        return np.stack(np.meshgrid(x_m, y_m), axis=2) + self._origin_m


def _costs(cost_map: CostMap, berth: Berth) -> Array:
    """Return the cost of a metre in every coarse cell, infinite where the body does not fit."""
    middle = slice(COARSE // 2, None, COARSE)
    return _cost_a_metre(cost_map.clearances_m[middle, middle].astype(np.float64), unknown_of(cost_map)[middle, middle], berth)


def _cost_a_metre(clearances_m: Array, unknown: NDArray[np.bool_], berth: Berth) -> Array:
    lacking = np.clip((berth.wished_m - clearances_m) / (berth.wished_m - berth.least_m), 0.0, 1.0)
    costs = 1.0 + NARROW_COST * lacking**2 + np.where(unknown, berth.unknown_cost, 0.0)
    return np.where(clearances_m >= berth.least_m, costs, np.inf)


def _open_start(costs: Array, centres_m: Array, start_m: Array, cost_map: CostMap) -> None:
    """Let a body that stands too near to something leave."""
    near = np.hypot(*(centres_m - start_m).transpose(2, 0, 1)) < ESCAPE_M
    costs[near & ~np.isfinite(costs) & (cost_map.clearance_m(centres_m) > 0.0)] = ESCAPE_COST


def _graph(costs: Array) -> csr_array:
    """Return the graph of all moves between neighbouring cells, in both directions, in cells of length."""
    ends, lengths = _moves(*costs.shape)
    flat = costs.reshape(-1)
    weights = 0.5 * lengths * (flat[ends[0]] + flat[ends[1]])
    fits = np.isfinite(weights)
    return csr_array((weights[fits], (ends[0][fits], ends[1][fits])), shape=(flat.size, flat.size))


@lru_cache(maxsize=4)
def _moves(rows: int, columns: int) -> tuple[NDArray[np.int32], Array]:
    """Return the cells that moves join, shape (2, n), and how long the moves are, shape (n,) [cells]."""
    index = np.arange(rows * columns, dtype=np.int32).reshape(rows, columns)
    ends, lengths = [], []
    for down, right in ((0, 1), (1, 0), (1, 1), (1, -1)):
        first = index[: rows - down, max(0, -right) : columns - max(0, right)].reshape(-1)
        second = index[down:, max(0, right) : columns - max(0, -right)].reshape(-1)
        ends += [np.stack([first, second]), np.stack([second, first])]
        lengths.append(np.full(2 * first.size, float(np.hypot(down, right))))
    return np.concatenate(ends, axis=1), np.concatenate(lengths)


def cost_of_way(cost_map: CostMap, way_m: Array, berth: Berth) -> float:
    """Return the cost of a way, shape (n, 2), as `Reach` counts it; infinite where the body does not fit."""
    if len(way_m) < 2:
        return 0.0
    costs = _cost_a_metre(cost_map.clearance_m(way_m).astype(np.float64), cost_map.is_unknown(way_m), berth)
    return float(costs[1:] @ np.hypot(*np.diff(way_m, axis=0).T))
