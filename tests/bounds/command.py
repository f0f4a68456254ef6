"""What `python -m tests.bounds` does, with somebody at the terminal."""

from __future__ import annotations

import json
import time
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console

from protocol.errors import OmmatidiaError
from tests.bench.screen import print_tables
from tests.bounds.measurements import Desk, Measurement, all_measurements
from tests.bounds.verdicts import comparison_table, document, judge, verdict_table

MISSED, BAD_USAGE = 1, 2
RESULT_FILE = "bounds.json"


def bounds(out: Path, markdown: bool) -> int:
    """Measure all that can be, print the tables, write `out`/bounds.json, and return the exit code: 1 where a bound is missed."""
    progress = Console(stderr=True)
    measurements = all_measurements()
    missing = {measurement.name: reason for measurement in measurements if (reason := measurement.missing)}
    try:
        out.mkdir(parents=True, exist_ok=True)
        figures = measure([each for each in measurements if each.name not in missing], Desk(out, progress))
    except OmmatidiaError as error:
        progress.print(f"bounds: {error}", soft_wrap=True, markup=False)
        return BAD_USAGE
    verdicts = judge(figures, missing)
    print_tables([table for table in (verdict_table(verdicts), comparison_table(figures)) if table.row_count], markdown)
    (out / RESULT_FILE).write_text(json.dumps(document(verdicts, figures), indent=1) + "\n", encoding="utf-8")
    progress.print(f"wrote {out / RESULT_FILE}; the runs lie beside it", soft_wrap=True)
    return MISSED if any(verdict.failed for verdict in verdicts) else 0


def measure(measurements: Sequence[Measurement], desk: Desk) -> dict[str, float]:
    """Make one measurement after the other, say which and how long it took, and return all figures by `<measurement>.<figure>`."""
    figures: dict[str, float] = {}
    for number, measurement in enumerate(measurements, start=1):
        desk.console.print(f"{number}/{len(measurements)} {measurement.name}", highlight=False)
        start_s = time.monotonic()
        figures |= {f"{measurement.name}.{figure}": value for figure, value in measurement.measure(desk).items()}
        desk.console.print(f"    {time.monotonic() - start_s:.1f} s", highlight=False, style="dim")
    return figures
