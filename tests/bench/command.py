"""What `python -m tests.bench` does, with somebody at the terminal."""

from __future__ import annotations

import json
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from rich.console import Console
from rich.progress import Progress

from protocol.errors import OmmatidiaError
from tests.bench.contest import Result, measure
from tests.bench.frames import Case, all_cases
from tests.bench.pose_graph import POSES, measure_graph
from tests.bench.report import document, graph_table, tables
from tests.bench.screen import print_tables

BAD_USAGE = 2


def bench(out: Path, most_frames: int | None, markdown: bool) -> int:
    """Measure, print the tables, write `out`, and return the exit code."""
    progress = Console(stderr=True)
    try:
        results = measure_all(all_cases(), progress, most_frames)
        with progress.status(f"the pose graph, {POSES} poses"):
            graph = measure_graph()
    except OmmatidiaError as error:
        progress.print(f"bench: {error}", soft_wrap=True, markup=False)
        return BAD_USAGE
    print_tables([*tables(results), graph_table(graph)], markdown)
    out.parent.mkdir(parents=True, exist_ok=True)
    out.write_text(json.dumps(document(results, graph), indent=1) + "\n", encoding="utf-8")
    progress.print(f"wrote {out}", soft_wrap=True)
    return 0


def measure_all(cases: Sequence[Case], console: Console, most_frames: int | None = None) -> list[Result]:
    """Measure one case after the other, with a bar for each."""
    results = []
    with Progress(console=console) as progress:
        for case in cases:
            task = progress.add_task(f"{case.name}, {case.size_px[0]}x{case.size_px[1]}", total=case.count(most_frames))
            results.append(measure(case, partial(progress.advance, task), most_frames))
    return results
