"""What `ommatidia evaluate` does, with somebody at the terminal."""

from __future__ import annotations

import json
from pathlib import Path

from rich.console import Console
from rich.progress import Progress

from deploy.ablation import ablation, variants
from deploy.account import ACCOUNT_FILE
from deploy.evaluation.document import team_document
from deploy.evaluation.evaluate import evaluate
from deploy.evaluation.mrclam_truth import is_mrclam
from deploy.evaluation.report import write_evaluation
from deploy.evaluation.tables import ablation_table
from deploy.evaluation.team_report import evaluate_team, write_team_evaluation
from deploy.folders import CALIBRATED_LENS
from protocol.errors import ConfigError

ABLATION_FILE = "ablation.json"


def evaluate_run(run: Path, truth: Path, console: Console, *, ablates: bool = False) -> None:
    """Print the tables of a run, and of a second run inside it, beside the truth; leave evaluation.json and figures/ in their folders.

    Beside a folder of the UTIAS data set, the team is aligned as a whole, and there are no figures. With `ablates`, the recording is gone
    through again with more and more of the method; ablation.json is left in the folder. Raises OmmatidiaError.
    """
    if is_mrclam(truth):
        if ablates:
            raise ConfigError("--ablation needs a recording of cameras: folders of the UTIAS data set have none")
        write_team_evaluation(evaluate_team(run, truth), console)
        return
    inner = run / CALIBRATED_LENS
    for folder in [run, inner] if (inner / ACCOUNT_FILE).is_file() else [run]:
        with console.status(f"evaluating {folder}"):
            evaluation = evaluate(folder, truth)
        write_evaluation(evaluation, console)
    if ablates:
        _ablate(run, truth, console)


def _ablate(run: Path, truth: Path, console: Console) -> None:
    """Print what each part of the method is worth."""
    with Progress(console=console, transient=True) as bar:
        tasks = {row.name: bar.add_task(row.name, total=1.0) for row in variants()}
        rows = ablation(truth, lambda name, share: bar.update(tasks[name], completed=share))
    console.print(ablation_table(rows, truth.resolve().name))
    content = {name: team_document(team) for name, team in rows.items()}
    (run / ABLATION_FILE).write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
