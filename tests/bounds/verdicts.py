"""From figures to verdicts, as tables for the screen and as plain values for a file."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from rich.markup import escape
from rich.table import Table

from tests.bench.report import machine
from tests.bench.screen import new_table
from tests.bounds.table import BOUNDS, COMPARED, COMPARED_ON, METHODS, Bound

Figures = Mapping[str, float]  # by `<measurement>.<figure>`
NOTHING = "-"
NOT_MEASURED = "not measured"


@dataclass(frozen=True)
class Verdict:
    """One bound and what was measured; `reason` says why nothing was."""

    bound: Bound
    value: float | None
    reason: str | None = None

    @property
    def failed(self) -> bool:
        """Tell whether the figure was measured and misses its bound."""
        return self.value is not None and not self.bound.holds(self.value)

    @property
    def word(self) -> str:
        """The verdict in a word."""
        if self.value is None:
            return NOT_MEASURED
        return "FAILED" if self.failed else "holds"


def judge(figures: Figures, missing: Mapping[str, str], bounds: Sequence[Bound] = BOUNDS) -> list[Verdict]:
    """Return a verdict for every bound; `missing` says, by measurement, why one could not be made.

    Raises KeyError for a figure that no measurement gives.
    """
    return [
        Verdict(bound, None, missing[bound.measurement]) if bound.measurement in missing else Verdict(bound, figures[bound.figure])
        for bound in bounds
    ]


def verdict_table(verdicts: Sequence[Verdict]) -> Table:
    """Return every bound with its figure."""
    table = new_table("Bounds", "what", "figure", "bound", "")
    for verdict in verdicts:
        bound = verdict.bound
        limit = f"{bound.relation} {bound.limit:g} {bound.unit}".strip()
        table.add_row(bound.what, _number(verdict.value, bound.unit), limit, verdict.word, style="bold red" if verdict.failed else "")
    if reasons := sorted({verdict.reason for verdict in verdicts if verdict.reason}):
        table.caption = f"{NOT_MEASURED}: {'; '.join(reasons)}"
    return table


def comparison_table(figures: Figures) -> Table:
    """Return our best beside the paper's method, with its own lens and with the calibrated one, on what recordings there are."""
    table = new_table("Beside the paper's method, on the same recordings", "what", *METHODS)
    for recording in COMPARED_ON:
        names = [recording if method == "full" else f"{recording} {method}" for method in METHODS]
        for what, figure in COMPARED if f"{recording}.{COMPARED[0][1]}" in figures else ():
            table.add_row(escape(f"{recording}: {what}"), *(_number(figures[f"{name}.{figure}"]) for name in names))
    return table


def document(verdicts: Sequence[Verdict], figures: Figures) -> dict[str, Any]:
    """Return everything as plain values for bounds.json."""
    return {
        "version": 1,
        "machine": machine(),
        "failed": sum(verdict.failed for verdict in verdicts),
        "bounds": [_entry(verdict) for verdict in verdicts],
        "figures": {name: _plain(value) for name, value in figures.items()},
    }


def _entry(verdict: Verdict) -> dict[str, Any]:
    bound = verdict.bound
    limit = {"relation": bound.relation, "limit": bound.limit, "unit": bound.unit}
    return {
        "what": bound.what,
        "figure": bound.figure,
        "value": _plain(verdict.value),
        **limit,
        "verdict": verdict.word,
        "reason": verdict.reason,
    }


def _number(value: float | None, unit: str = "") -> str:
    return NOTHING if value is None or math.isnan(value) else f"{value:.4g} {unit}".strip()


def _plain(value: float | None) -> float | None:
    return None if value is None or not math.isfinite(value) else round(value, 6)
