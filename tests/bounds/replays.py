"""Figures of whole runs: a recording replayed through real processes, and judged by its truth."""

from __future__ import annotations

import math
from dataclasses import fields
from pathlib import Path

from rich.console import Console

from agent.pipeline import Method
from deploy.account import RunAccount
from deploy.display import ReplayBar
from deploy.evaluation.evaluate import evaluate
from deploy.evaluation.rig_metrics import RigScore
from deploy.evaluation.team_report import evaluate_team
from deploy.folders import prepare_folder
from deploy.replay import NOTHING_LOST, Plan, replay
from deploy.replay_command import UnknownStarts, with_told_starts
from deploy.sources import CameraSource, MrclamSource, Source
from mapserver.config import LossSettings
from sim.mrclam import MrclamRecording
from sim.recording import Recording

RIG_FIGURES = tuple(field.name for field in fields(RigScore))
LOST = LossSettings(share=0.2, seed=1)
_COMPARED_FILES = ("trajectories/*.tum", "trajectories/smoothed/*.tum", "map.geojson", "map.pgm")


def replay_figures(
    recording: Path, out: Path, console: Console, method: Method = "full", unknown_starts: UnknownStarts = "none"
) -> dict[str, float]:
    """Replay a recording into the folder `out`, replacing the run that lies there, and return what the evaluation says of it."""
    source = CameraSource(with_told_starts(Recording.open(recording), unknown_starts), method)
    account = _run(source, out, console, f"{recording.resolve().name}, {method}")
    evaluation = evaluate(out, recording)
    paths, shown = evaluation.live.mean, evaluation.map
    sizes = [robot.bytes_per_frame for robot in account.robots.values()]
    return {
        **{f"rig_{name}": max(getattr(rig, name) for rig in evaluation.rigs.values()) for name in RIG_FIGURES if evaluation.rigs},
        "path_error_cm": 100.0 * paths.distance_m.mean,
        "path_error_max_cm": 100.0 * paths.distance_m.max,
        "heading_error_deg": math.degrees(paths.heading_rad.mean),
        "aligned_rmse_max_cm": 100.0 * max(score.aligned_rmse_m for score in evaluation.live.robots.values()),
        "joined_s": paths.joined_s,
        "missing_poses": float(paths.expected - paths.matched),
        "recall": shown.recall,
        "precision": shown.precision,
        "invented": float(len(shown.invented)),
        "robots_drawn": float(shown.count("robot")),
        "carried_away_drawn": float(shown.count("carried away")),
        "centre_cm": 100.0 * shown.centre_error_m.median,
        "iou": shown.iou.median,
        "bytes_median": float(max(size.median for size in sizes)),
        "bytes_max": float(max(size.max for size in sizes)),
    }


def team_figures(recording: Path, out: Path, console: Console) -> dict[str, float]:
    """Replay a folder of the UTIAS data set, once as it is and once with messages lost, and return what the evaluation says of both."""
    source = MrclamSource(MrclamRecording.open(recording))
    account = _run(source, out, console, source.label)
    lossy = out.with_name(f"{out.name}-lossy")
    _run(source, lossy, console, f"{source.label}, {LOST.share:.0%} lost", loss=LOST)
    told, lost = evaluate_team(out, recording), evaluate_team(lossy, recording)
    stamps_ns = [step.stamp_ns for step in source.steps()]
    assert account.pace is not None
    return {
        "live_m": told.live.team_rmse_m,
        "smoothed_m": told.smoothed.team_rmse_m if told.smoothed else math.nan,
        "speed": 1e-9 * (max(stamps_ns) - min(stamps_ns)) / account.pace.wall_s,
        "lossy_over_live": lost.live.team_rmse_m / told.live.team_rmse_m,
    }


def paced_run(recording: Path, out: Path, console: Console) -> None:
    """Replay a recording at its recorded pace into the folder `out`, replacing the run that lies there."""
    _run(CameraSource(Recording.open(recording), "full"), out, console, f"{recording.resolve().name}, paced", rate=1.0)


def _run(source: Source, out: Path, console: Console, label: str, rate: float = math.inf, loss: LossSettings = NOTHING_LOST) -> RunAccount:
    prepare_folder(out, overwrite=True)
    with ReplayBar(source, label, console) as bar:
        return replay(Plan(source, out, rate, loss), bar)


def files_that_differ(one: Path, other: Path) -> list[str]:
    """Return which results, of all in either run's folder, are not the same byte for byte."""
    names = {str(file.relative_to(folder)) for folder in (one, other) for pattern in _COMPARED_FILES for file in folder.glob(pattern)}
    return sorted(name for name in names if _content(one / name) != _content(other / name))


def _content(file: Path) -> bytes | None:
    return file.read_bytes() if file.is_file() else None
