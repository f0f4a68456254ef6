"""What was measured, as tables for the screen and as plain values for a file."""

from __future__ import annotations

import os
import platform
from collections.abc import Sequence
from typing import Any

import cv2
import numpy as np
from rich.table import Table

from tests.bench.contest import CLASSICAL, DECODE, ENCODE, POINTS, STEP, WHOLE, Result
from tests.bench.pose_graph import BARE, OWN, POSES, GraphContest
from tests.bench.screen import new_table
from tests.bench.statistics import Ratio

CLOCK = "processor time of one thread"


def tables(results: Sequence[Result]) -> list[Table]:
    """Return all tables, in the order in which a person reads them."""
    return [stages_table(results), contest_table(results), bytes_table(results)]


def stages_table(results: Sequence[Result]) -> Table:
    """Return the milliseconds of every stage of the agent, with decoding as a row of its own."""
    table = new_table(f"The agent, milliseconds per frame, p50 and p99 ({CLOCK})", "stage", *map(_heading, results))
    table.add_row(DECODE, *(_times(result, DECODE) for result in results), end_section=True)
    stages = [name for name in results[0].ms if name not in (DECODE, STEP, CLASSICAL, POINTS, WHOLE)]
    for name in sorted(stages, key=lambda name: name == ENCODE):
        table.add_row(name, *(_times(result, name) for result in results))
    table.add_row(STEP, *(_times(result, STEP) for result in results), style="bold")
    return table


def contest_table(results: Sequence[Result]) -> Table:
    """Return what is compared, measured side by side on every frame."""
    table = new_table("Side by side on every frame, milliseconds and ratios of medians", "", *map(_heading, results))
    for name in (STEP, CLASSICAL):
        table.add_row(name, *(_times(result, name) for result in results))
    _add_ratios(table, "step / classical", [result.step_over_classical for result in results])
    for name in (POINTS, WHOLE):
        table.add_row(f"correct {name}", *(_times(result, name) for result in results))
    _add_ratios(table, "points / whole", [result.points_over_whole for result in results])
    table.add_row("points in a frame", *(f"{np.median(result.points):.0f}" for result in results))
    return table


def bytes_table(results: Sequence[Result]) -> Table:
    """Return what a frame costs on the bus."""
    table = new_table("Local map and motion vectors of a frame, encoded bytes", "", *map(_heading, results))
    for name in ("mean", "p99", "max"):
        table.add_row(name, *(f"{byte_figures(result)[name]:.0f}" for result in results))
    return table


def graph_table(graph: GraphContest) -> Table:
    """Return what the pose graph's update costs beside bare iSAM2; the sum over all steps is what counts."""
    table = new_table(f"The pose graph, milliseconds a step up to {POSES} poses, p50 and p99", "", "")
    for name, (p50_ms, p99_ms) in ((OWN, graph.own), (BARE, graph.bare)):
        table.add_row(name, f"{p50_ms:.2f} {p99_ms:6.2f}")
    _add_ratios(table, "update / bare, medians", [graph.ratio_of_medians])
    table.add_row("update / bare, all steps", f"{graph.ratio_of_sums:.3f}", style="bold")
    return table


def byte_figures(result: Result) -> dict[str, float]:
    """Return mean, p99 and max of the encoded bytes of a frame."""
    sizes = result.frame_bytes
    return {"mean": float(np.mean(sizes)), "p99": float(np.quantile(sizes, 0.99)), "max": float(max(sizes))}


def document(results: Sequence[Result], graph: GraphContest) -> dict[str, Any]:
    """Return everything as plain values for bench.json."""
    return {"version": 1, "clock": CLOCK, "machine": machine(), "cases": [_case(result) for result in results], "pose_graph": _graph(graph)}


def machine() -> dict[str, Any]:
    """Return what the figures depend on."""
    return {
        "processor": platform.machine(),
        "cores": os.cpu_count(),
        "python": platform.python_version(),
        "numpy": np.__version__,
        "opencv": cv2.__version__,
    }


def _graph(graph: GraphContest) -> dict[str, Any]:
    return {
        "poses": POSES,
        "update_ms": _rounded(graph.own._asdict()),
        "bare_ms": _rounded(graph.bare._asdict()),
        "update_over_bare": round(graph.ratio_of_sums, 4),
        "medians": _rounded(graph.ratio_of_medians._asdict()),
    }


def _case(result: Result) -> dict[str, Any]:
    return {
        "name": result.name,
        "size_px": list(result.size_px),
        "frames": len(result.frame_bytes),
        "stages": {name: _rounded(times._asdict()) for name, times in result.stages.items()},
        "ratios": {
            "step_over_classical": _rounded(result.step_over_classical._asdict()),
            "points_over_whole": _rounded(result.points_over_whole._asdict()),
        },
        "points": float(np.median(result.points)),
        "bytes": _rounded(byte_figures(result)),
    }


def _heading(result: Result) -> str:
    return f"{result.name} {result.size_px[0]}x{result.size_px[1]}"


def _times(result: Result, name: str) -> str:
    p50_ms, p99_ms = result.stages[name]
    return f"{p50_ms:.2f} {p99_ms:6.2f}"


def _add_ratios(table: Table, name: str, ratios: Sequence[Ratio]) -> None:
    table.add_row(name, *(f"{ratio.value:.3f}" for ratio in ratios), style="bold")
    table.add_row("  95 % interval", *(f"{ratio.low:.3f}-{ratio.high:.3f}" for ratio in ratios), end_section=True)


def _rounded(values: dict[str, Any]) -> dict[str, float]:
    return {name: round(float(value), 4) for name, value in values.items()}
