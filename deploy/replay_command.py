"""What `ommatidia replay` does, with somebody at the terminal."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path
from typing import Literal

from rich.console import Console

from agent.pipeline import Method
from deploy.account import RunAccount
from deploy.display import ReplayBar
from deploy.folders import CALIBRATED_LENS, default_folder, prepare_folder
from deploy.replay import Plan, replay
from sim.recording import Recording


def replay_recording(
    recording_folder: Path, out: Path | None, method: Literal["full", "paper"], rate: float, overwrite: bool, console: Console
) -> Path:
    """Replay a recording and return the run's folder; the paper's method runs twice, the second time with the calibrated lens."""
    recording = Recording.open(recording_folder)
    for warning in recording.warnings:
        console.print(f"warning: {warning}", style="yellow", soft_wrap=True, markup=False)
    folder = out or default_folder(recording_folder, datetime.now())
    prepare_folder(folder, overwrite)
    for plan in _plans(recording, folder, method, rate):
        plan.folder.mkdir(exist_ok=True)
        with ReplayBar(recording, plan.method, console) as bar:
            account = replay(plan, bar)
        console.print(_summary(account, plan.folder), soft_wrap=True, markup=False, highlight=False)
    return folder


def _plans(recording: Recording, folder: Path, method: Literal["full", "paper"], rate: float) -> list[Plan]:
    runs: dict[Method, Path] = {method: folder}
    if method == "paper":
        runs["paper-calibrated"] = folder / CALIBRATED_LENS
    return [Plan(recording, place, name, rate) for name, place in runs.items()]


def _summary(account: RunAccount, folder: Path) -> str:
    pace = account.pace
    assert pace is not None
    dropped = sum(robot.frames.get("dropped", 0) for robot in account.robots.values())
    lag = "" if account.rate == "max" else f", at worst {pace.worst_lag_s:.2f} s behind recorded time"
    speed = f"in {pace.wall_s:.1f} s ({pace.frames_per_s:.1f} frames/s{lag})"
    return f"{account.method}: {pace.frames} frames of {len(account.robots)} robots {speed}, {dropped} dropped; wrote {folder}/"
