"""What an evaluation leaves: tables on the screen, and evaluation.json and figures/ in the run's folder."""

from __future__ import annotations

import json
from pathlib import Path

from rich.console import Console
from rich.progress import track

from deploy.evaluation.document import document
from deploy.evaluation.evaluate import Evaluation
from deploy.evaluation.figures import PlannedFigure, plan_figures, write_figure
from deploy.evaluation.tables import tables
from protocol.errors import RecordingError


def write_evaluation(evaluation: Evaluation, console: Console) -> None:
    """Print the tables, then write evaluation.json and figures/ into the run's folder and say where they are.

    Raises RecordingError where the run's folder cannot be written, or holds a picture that is none.
    """
    for table in tables(evaluation):
        console.print(table, "")
    folder = evaluation.run.path
    try:
        (folder / "evaluation.json").write_text(json.dumps(document(evaluation), indent=1, allow_nan=False) + "\n", encoding="utf-8")
        write_figures(evaluation, folder / "figures", console)
    except OSError as error:
        raise RecordingError(f"{error.filename or folder}: cannot be written ({error.strerror})") from error
    console.print(f"wrote {folder / 'evaluation.json'} and {folder / 'figures'}/", soft_wrap=True, markup=False, highlight=False)


def write_figures(evaluation: Evaluation, folder: Path, console: Console) -> None:
    """Draw all figures that the run has the pictures for; name those that it has not."""
    folder.mkdir(exist_ok=True)
    plans = plan_figures(evaluation)
    for plan in track([plan for plan in plans if not plan.missing], "drawing figures", console=console, transient=True):
        write_figure(plan, folder)
    skipped = [plan for plan in plans if plan.missing]
    if skipped:
        console.print(_skip_line(skipped), soft_wrap=True, markup=False, highlight=False)


def _skip_line(skipped: list[PlannedFigure]) -> str:
    pictures = sorted({file.name for plan in skipped for file in plan.missing})
    names = ", ".join(plan.file_name for plan in skipped)
    return f"skipped {names}: the run has no {', '.join(pictures)} in {skipped[0].missing[0].parent}/"
