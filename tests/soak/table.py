"""The results of many arenas as one table, and what was promised of them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Literal, NamedTuple

import numpy as np
from rich.box import MARKDOWN, SIMPLE_HEAD
from rich.table import Table
from rich.text import Text

from tests.soak.arenas import ArenaResult

Figure = Callable[[Sequence[ArenaResult]], float]


class Promise(NamedTuple):
    """One bound over all arenas."""

    what: str
    figure: Figure
    sign: Literal["<=", ">="]
    bound: float

    def holds(self, results: Sequence[ArenaResult]) -> bool:
        """Tell whether it is kept; what was not measured is not."""
        figure = self.figure(results)
        return figure <= self.bound if self.sign == "<=" else figure >= self.bound


def _sum(field: str) -> Figure:
    return lambda results: sum(getattr(result, field) for result in results)


def _worst(field: str) -> Figure:
    """Return the largest figure of any arena that has one; NaN where none has."""
    return lambda results: max((x for result in results if not math.isnan(x := float(getattr(result, field)))), default=math.nan)


def _mean(field: str) -> Figure:
    return lambda results: float(np.mean([getattr(result, field) for result in results]))


def _not_reached(results: Sequence[ArenaResult]) -> float:
    return sum(not result.reached for result in results)


# fmt: off
PROMISES = (
    Promise("collisions",                                         _sum("collisions"),    "<=", 0.0),
    Promise("arenas in which the goal was not reached",           _not_reached,          "<=", 0.0),
    Promise("formation error, steady, RMS, worst arena [cm]",     _worst("steady_cm"),   "<=", 2.0),
    Promise("formation error, avoiding, RMS, worst arena [cm]",   _worst("avoiding_cm"), "<=", 6.0),
    Promise("formation restored after, worst [s]",                _worst("restored_s"),  "<=", 5.0),
    Promise("path error, mean, worst arena [cm]",                 _worst("path_cm"),     "<=", 1.5),
    Promise("recall of obstacles, mean of all arenas",            _mean("recall"),       ">=", 0.95),
    Promise("obstacles invented",                                 _sum("invented"),      "<=", 0.0),
)
# fmt: on


def empty_table(title: str, columns: Sequence[str], markdown: bool) -> Table:
    """Return a table without rows; as Markdown it has no title. Columns are flush right, but for "what"."""
    table = Table(box=MARKDOWN if markdown else SIMPLE_HEAD, title=None if markdown else title, title_justify="left", pad_edge=markdown)
    for column in columns:
        table.add_column(Text(column), justify="left" if column == "what" else "right")
    return table


def results_table(results: Sequence[ArenaResult], markdown: bool) -> Table:
    """Return a row for every arena."""
    columns = ("seed", "robots", "goal", "time [s]", "collisions", "path", "steady", "avoiding", "restored [s]", "recall", "invented")
    table = empty_table("Arenas", columns, markdown)
    for result in results:
        table.add_row(
            str(result.seed),
            str(result.robots),
            "reached" if result.reached else result.ending,
            f"{result.world_s:.0f}",
            str(result.collisions),
            *(_plain(value, 2) for value in (result.path_cm, result.steady_cm, result.avoiding_cm)),
            _plain(result.restored_s, 1),
            _plain(result.recall, 2),
            str(result.invented),
        )
    return table


def promises_table(results: Sequence[ArenaResult], markdown: bool) -> Table:
    """Return what was promised over all arenas, and whether it holds."""
    table = empty_table("Bounds", ("what", "figure", "bound", ""), markdown)
    for promise in PROMISES:
        bound = f"{promise.sign} {promise.bound:g}"
        table.add_row(Text(promise.what), _plain(promise.figure(results), 2), bound, "holds" if promise.holds(results) else "FAILED")
    return table


def all_hold(results: Sequence[ArenaResult]) -> bool:
    """Tell whether every promise holds."""
    return all(promise.holds(results) for promise in PROMISES)


def _plain(value: float, digits: int) -> str:
    return "-" if math.isnan(value) else f"{value:.{digits}f}".removesuffix("." + "0" * digits)
