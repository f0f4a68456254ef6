"""What `python -m tests.bench.twin` does, with somebody at the terminal."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import partial
from pathlib import Path

from rich.console import Console
from rich.markup import escape
from rich.progress import Progress
from rich.table import Table

from protocol.errors import OmmatidiaError
from sim.recording import Recording
from tests.bench.screen import new_table, print_tables
from tests.bench.twin_maker import make_twin, recording_rows
from tests.bounds.replays import replay_figures

MISSED, BAD_USAGE = 1, 2
FACTOR = 2.0  # within which the twin's path error has to be
COMPARED = (("mean path error, live [cm]", "path_error_cm"), ("recall of obstacles", "recall"), ("obstacles invented", "invented"))

Figures = Mapping[str, float]  # of one run, as `replay_figures` gives them


def compare(recording: Path, out: Path, seed: int) -> int:
    """Make the twin, replay both, print their table, and return the exit code: 1 where the twin's path error is out of bounds."""
    progress = Console(stderr=True)
    try:
        recorded, twin = figures_of_both(recording, out, seed, progress)
    except OmmatidiaError as error:
        progress.print(f"twin: {error}", soft_wrap=True, markup=False, highlight=False)
        return BAD_USAGE
    ratio = path_ratio(recorded, twin)
    print_tables([_table(recording.resolve().name, recorded, twin)], markdown=False)
    verdict = "holds" if is_alike(ratio) else "FAILED"
    print(f"path error, twin over recording: {ratio:.2f}; bound: {1.0 / FACTOR:g} to {FACTOR:g}; {verdict}")
    return 0 if is_alike(ratio) else MISSED


def figures_of_both(recording: Path, out: Path, seed: int, console: Console) -> tuple[Figures, Figures]:
    """Return the figures of the recording's run and of its twin's; both runs and the twin are left in the folder `out`."""
    opened = Recording.open(recording)
    frames = sum(len(recording_rows(opened, name)) for name in opened.names)
    with Progress(console=console) as progress:
        task = progress.add_task("painting the twin", total=frames)
        make_twin(opened, out / "twin", seed, partial(progress.advance, task))
    return replay_figures(recording, out / "run", console), replay_figures(out / "twin", out / "twin_run", console)


def path_ratio(recorded: Figures, twin: Figures) -> float:
    """Return the twin's path error over the recording's."""
    return twin["path_error_cm"] / recorded["path_error_cm"] if recorded["path_error_cm"] else math.nan


def is_alike(ratio: float) -> bool:
    """Tell whether a ratio of path errors is near enough to one."""
    return 1.0 / FACTOR <= ratio <= FACTOR


def _table(name: str, recorded: Figures, twin: Figures) -> Table:
    table = new_table(f"{name} and its simulated twin", "what", "recording", "twin")
    for what, figure in COMPARED:
        table.add_row(escape(what), f"{recorded[figure]:.4g}", f"{twin[figure]:.4g}")
    return table
