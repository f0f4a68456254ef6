"""What `ommatidia replay` does, with somebody at the terminal."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path
from typing import Literal, NamedTuple

from rich.console import Console

from agent.pipeline import Method
from deploy.account import RobotAccount, RunAccount
from deploy.display import ReplayBar
from deploy.folders import CALIBRATED_LENS, default_folder, prepare_folder
from deploy.replay import Plan, replay
from sim.recording import Recording

UnknownStarts = Literal["none", "others", "all"]  # whose starts are withheld; others: of all but the first by name


class Wishes(NamedTuple):
    """What was asked for on the command line."""

    out: Path | None
    method: Literal["full", "paper"]
    rate: float
    unknown_starts: UnknownStarts
    overwrite: bool


def replay_recording(recording_folder: Path, wishes: Wishes, console: Console) -> Path:
    """Replay a recording and return the run's folder; the paper's method runs twice, the second time with the calibrated lens."""
    recording = with_told_starts(Recording.open(recording_folder), wishes.unknown_starts)
    for warning in recording.warnings:
        console.print(f"warning: {warning}", style="yellow", soft_wrap=True, markup=False)
    folder = wishes.out or default_folder(recording_folder, datetime.now())
    prepare_folder(folder, wishes.overwrite)
    for plan in _plans(recording, folder, wishes.method, wishes.rate):
        plan.folder.mkdir(exist_ok=True)
        with ReplayBar(recording, plan.method, console) as bar:
            account = replay(plan, bar)
        console.print(_summary(account, plan.folder), soft_wrap=True, markup=False, highlight=False)
    return folder


def with_told_starts(recording: Recording, unknown: UnknownStarts) -> Recording:
    """Return the recording without the starts that are to be withheld."""
    names = sorted(recording.names)
    return recording.without_starts({"none": [], "others": names[1:], "all": names}[unknown])


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
    seekers = "".join(_joined(name, robot) for name, robot in account.robots.items() if robot.unplaced)
    return f"{account.method}: {pace.frames} frames of {len(account.robots)} robots {speed}, {dropped} dropped{seekers}; wrote {folder}/"


def _joined(name: str, robot: RobotAccount) -> str:
    """Return when a robot found its place."""
    if robot.joined_ns is None:
        return f"; {name} has not found its place"
    return f"; {name} found its place after {robot.unplaced} frames"
