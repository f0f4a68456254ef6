"""What `ommatidia evaluate` does, with somebody at the terminal."""

from __future__ import annotations

from pathlib import Path

from rich.console import Console

from deploy.account import ACCOUNT_FILE
from deploy.evaluation.evaluate import evaluate
from deploy.evaluation.mrclam_truth import is_mrclam
from deploy.evaluation.report import write_evaluation
from deploy.evaluation.team_report import evaluate_team, write_team_evaluation
from deploy.folders import CALIBRATED_LENS


def evaluate_run(run: Path, truth: Path, console: Console) -> None:
    """Print the tables of a run, and of a second run inside it, beside the truth; leave evaluation.json and figures/ in their folders.

    Beside a folder of the UTIAS data set, the team is aligned as a whole, and there are no figures.
    """
    if is_mrclam(truth):
        write_team_evaluation(evaluate_team(run, truth), console)
        return
    inner = run / CALIBRATED_LENS
    for folder in [run, inner] if (inner / ACCOUNT_FILE).is_file() else [run]:
        with console.status(f"evaluating {folder}"):
            evaluation = evaluate(folder, truth)
        write_evaluation(evaluation, console)
