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
from deploy.folders import prepare_folder
from deploy.replay import Plan, replay
from deploy.sources import CameraSource
from sim.recording import Recording

RIG_FIGURES = tuple(field.name for field in fields(RigScore))
_COMPARED_FILES = ("trajectories/*.tum", "trajectories/smoothed/*.tum", "map.geojson", "map.pgm")


def replay_figures(recording: Path, out: Path, console: Console, method: Method = "full", rate: float = math.inf) -> dict[str, float]:
    """Replay a recording into the folder `out`, replacing the run that lies there, and return what the evaluation says of it."""
    account = run(recording, out, console, method, rate)
    evaluation = evaluate(out, recording)
    paths, shown = evaluation.live.mean, evaluation.map
    sizes = [robot.bytes_per_frame for robot in account.robots.values()]
    return {
        **{f"rig_{name}": max(getattr(rig, name) for rig in evaluation.rigs.values()) for name in RIG_FIGURES if evaluation.rigs},
        "path_error_cm": 100.0 * paths.distance_m.mean,
        "path_error_max_cm": 100.0 * paths.distance_m.max,
        "heading_error_deg": math.degrees(paths.heading_rad.mean),
        "aligned_rmse_max_cm": 100.0 * max(score.aligned_rmse_m for score in evaluation.live.robots.values()),
        "missing_poses": float(paths.expected - paths.matched),
        "recall": shown.recall,
        "precision": shown.precision,
        "invented": float(len(shown.invented)),
        "robots_drawn": float(shown.count("robot")),
        "centre_cm": 100.0 * shown.centre_error_m.median,
        "iou": shown.iou.median,
        "bytes_median": float(max(size.median for size in sizes)),
        "bytes_max": float(max(size.max for size in sizes)),
    }


def run(recording: Path, out: Path, console: Console, method: Method, rate: float) -> RunAccount:
    """Replay a recording into the folder `out`, replacing the run that lies there."""
    opened = Recording.open(recording)
    prepare_folder(out, overwrite=True)
    source = CameraSource(opened, method)
    with ReplayBar(source, f"{opened.folder.resolve().name}, {method}", console) as bar:
        return replay(Plan(source, out, rate), bar)


def files_that_differ(one: Path, other: Path) -> list[str]:
    """Return which results, of all in either run's folder, are not the same byte for byte."""
    names = {str(file.relative_to(folder)) for folder in (one, other) for pattern in _COMPARED_FILES for file in folder.glob(pattern)}
    return sorted(name for name in names if _content(one / name) != _content(other / name))


def _content(file: Path) -> bytes | None:
    return file.read_bytes() if file.is_file() else None
