"""What an evaluation of a whole team leaves: one table on the screen, and evaluation.json in the run's folder.

version         1; grows when a key changes its meaning
run, recording  names of the two folders
alignment       "team": one SE(2) motion of all robots together, of live and smoothed paths each
live, smoothed  (smoothed is null where the run has none) team_rmse_m, largest_robot_rmse_m,
                robots by name: rmse_m, poses_matched, poses; null where nothing could be measured
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console
from rich.table import Table

from deploy.evaluation.mrclam_truth import read_mrclam_truth
from deploy.evaluation.run_folder import read_paths
from deploy.evaluation.team_metrics import TeamScore, score_together
from protocol.errors import RecordingError

Document = dict[str, object]
VERSION = 1


@dataclass(frozen=True)
class TeamEvaluation:
    """A run beside the truth."""

    run: Path
    recording: Path
    live: TeamScore
    smoothed: TeamScore | None


def evaluate_team(run: Path, recording: Path) -> TeamEvaluation:
    """Return the scores of a run; RecordingError, one line, where run or truth cannot be used or do not belong together."""
    truth = read_mrclam_truth(recording)
    live, smoothed = read_paths(run)
    score = score_together(live, truth)
    if not any(score.matched.values()):
        raise RecordingError(f"{run}: no pose has a stamp of {recording}: this is a run on another recording")
    return TeamEvaluation(run, recording, score, score_together(smoothed, truth) if smoothed else None)


def write_team_evaluation(evaluation: TeamEvaluation, console: Console) -> None:
    """Print the table, then write evaluation.json and say where it is; RecordingError where it cannot be written."""
    console.print(team_table(evaluation), "")
    file = evaluation.run / "evaluation.json"
    try:
        file.write_text(json.dumps(team_document(evaluation), indent=1, allow_nan=False) + "\n", encoding="utf-8")
    except OSError as error:
        raise RecordingError(f"{file}: cannot be written ({error.strerror})") from error
    console.print(f"wrote {file}", soft_wrap=True, markup=False, highlight=False)


def team_table(evaluation: TeamEvaluation) -> Table:
    """Return the table: a row for the team and for each robot, a column for live and smoothed paths."""
    table = Table(title="RMSE of positions \\[m] after one SE(2) alignment of the whole team")
    for heading in ("", "live", "smoothed", "poses matched"):
        table.add_column(heading, justify="left" if not heading else "right")
    live, smoothed = evaluation.live, evaluation.smoothed
    rows = {"team": live.team_rmse_m, "largest": live.largest_rmse_m, **live.robots_rmse_m}
    late = {} if smoothed is None else {"team": smoothed.team_rmse_m, "largest": smoothed.largest_rmse_m, **smoothed.robots_rmse_m}
    for name, rmse_m in rows.items():
        matched = f"{live.matched[name]}/{live.expected[name]}" if name in live.matched else ""
        table.add_row(name, f"{rmse_m:.4f}", f"{late[name]:.4f}" if late else "-", matched)
    return table


def team_document(evaluation: TeamEvaluation) -> Document:
    """Return the evaluation under the keys that this file's head lists."""
    return {
        "version": VERSION,
        "run": evaluation.run.resolve().name,
        "recording": evaluation.recording.resolve().name,
        "alignment": "team",
        "live": _score(evaluation.live),
        "smoothed": None if evaluation.smoothed is None else _score(evaluation.smoothed),
    }


def _score(score: TeamScore) -> Document:
    return {
        "team_rmse_m": _number(score.team_rmse_m),
        "largest_robot_rmse_m": _number(score.largest_rmse_m),
        "robots": {
            robot: {"rmse_m": _number(rmse_m), "poses_matched": score.matched[robot], "poses": score.expected[robot]}
            for robot, rmse_m in score.robots_rmse_m.items()
        },
    }


def _number(value: float) -> float | None:
    return round(value, 6) if math.isfinite(value) else None
