"""What `ommatidia replay` does, with somebody at the terminal."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path
from typing import Literal, NamedTuple

from rich.console import Console

from deploy.account import RobotAccount, RunAccount
from deploy.display import ReplayBar
from deploy.folders import CALIBRATED_LENS, default_folder, prepare_folder
from deploy.replay import Plan, replay
from deploy.sources import CameraSource, MrclamSource, Source
from mapserver.config import LossSettings
from protocol.errors import ConfigError
from sim.mrclam import MrclamRecording
from sim.recording import Recording

Format = Literal["recording", "mrclam"]
UnknownStarts = Literal["none", "others", "all"]  # whose starts are withheld; others: of all but the first by name


class Wishes(NamedTuple):
    """What was asked for on the command line."""

    recording: Path
    format: Format
    out: Path | None
    method: Literal["full", "paper"]
    rate: float
    unknown_starts: UnknownStarts
    loss: LossSettings
    overwrite: bool


def replay_recording(wishes: Wishes, console: Console) -> Path:
    """Replay a recording and return the run's folder; the paper's method runs twice, the second time with the calibrated lens."""
    folder = wishes.out or default_folder(wishes.recording, datetime.now())
    sources = _sources(wishes, folder)
    for warning in sources[folder].warnings:
        console.print(f"warning: {warning}", style="yellow", soft_wrap=True, markup=False)
    prepare_folder(folder, wishes.overwrite)
    for place, source in sources.items():
        place.mkdir(exist_ok=True)
        with ReplayBar(source, source.label, console) as bar:
            account = replay(Plan(source, place, wishes.rate, wishes.loss), bar)
        console.print(_summary(account, place), soft_wrap=True, markup=False, highlight=False)
    return folder


def with_told_starts(recording: Recording, unknown: UnknownStarts) -> Recording:
    """Return the recording without the starts that are to be withheld."""
    names = sorted(recording.names)
    return recording.without_starts({"none": [], "others": names[1:], "all": names}[unknown])


def _sources(wishes: Wishes, folder: Path) -> dict[Path, Source]:
    """Return what is to be replayed, by the folder of its run."""
    if wishes.format == "mrclam":
        if wishes.method != "full" or wishes.unknown_starts != "none":
            raise ConfigError("--method and --unknown-starts are for recordings of cameras, not for --format mrclam")
        return {folder: MrclamSource(MrclamRecording.open(wishes.recording))}
    recording = with_told_starts(Recording.open(wishes.recording), wishes.unknown_starts)
    runs: dict[Path, Source] = {folder: CameraSource(recording, wishes.method)}
    if wishes.method == "paper":
        runs[folder / CALIBRATED_LENS] = CameraSource(recording, "paper-calibrated")
    return runs


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
