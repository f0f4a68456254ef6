"""What `ommatidia calibrate lens` does, with somebody at the terminal."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from rich.console import Console
from rich.progress import Progress

from agent.lens_calibration.board import Board
from agent.lens_calibration.calibration import LensCalibration, calibrate_lens
from agent.lens_calibration.verdict import Verdict
from deploy.calibration.lens_figure import write_lens_figure
from deploy.calibration.photos import Album, photo_files, read_photos
from deploy.calibration.sensor_file import write_sensor_file
from protocol.errors import ConfigError

SENSOR_FILE, FIGURE_FILE = "sensor.yaml", "lens.png"
WORTH_TELLING_PX = 0.02


@dataclass(frozen=True)
class Wishes:
    """What was asked for on the command line."""

    photos: tuple[Path, ...]
    board: Board
    out: Path
    height_m: float
    mount: Path | None
    overwrite: bool


def calibrate_lens_of(wishes: Wishes, console: Console, now: datetime) -> None:
    """Calibrate a lens from photos; leave sensor.yaml and lens.png in a folder. Raises ConfigError where the photos cannot carry it."""
    files = photo_files(wishes.photos)
    sensor_file = wishes.out / SENSOR_FILE
    if sensor_file.exists() and not wishes.overwrite:
        raise ConfigError(f"{sensor_file}: is there already; replace it with --overwrite, or name another folder with --out")
    album = read_photos(files)
    calibration = _calibrated(album, wishes.board, console)
    wishes.out.mkdir(parents=True, exist_ok=True)
    write_lens_figure(calibration, wishes.out / FIGURE_FILE)
    _tell(calibration, album.complaints, console)
    console.print(f"picture: {wishes.out / FIGURE_FILE}", soft_wrap=True)
    if calibration.verdict.grade == "refused":
        raise ConfigError(f"the photos cannot carry a calibration: {'; '.join(calibration.verdict.reasons)}")
    off_px = write_sensor_file(calibration, sensor_file, now, wishes.height_m, wishes.mount)
    if off_px > WORTH_TELLING_PX:
        console.print(f"sensor.yaml says it as a Kannala-Brandt lens, which draws up to {off_px:.2f} px differently")
    console.print(f"lens:    {sensor_file}", soft_wrap=True)


def _calibrated(album: Album, board: Board, console: Console) -> LensCalibration:
    with Progress(console=console, transient=True) as bar:
        task = bar.add_task("looking for the board", total=len(album.photos))
        return calibrate_lens(album.photos, board, lambda name: bar.update(task, advance=1, description=name))


def _tell(calibration: LensCalibration, complaints: Mapping[str, str], console: Console) -> None:
    """Say in plain words what the lens is, what it is worth, and which photos to take again."""
    camera, verdict = calibration.fit.camera, calibration.verdict
    fx, fy, cx, cy = camera.values[:4]
    console.print(f"{camera.family.name} lens, centre {cx:.1f} {cy:.1f} px, focal length {fx:.1f} {fy:.1f} px/rad", highlight=False)
    for line in verdict_lines(verdict):
        console.print(line, highlight=False, soft_wrap=True)
    unused = {photo.name: photo.complaint for photo in calibration.photos if photo.complaint} | dict(complaints)
    for name, complaint in unused.items():
        console.print(f"  take again: {name}: {complaint}", highlight=False, soft_wrap=True)


def verdict_lines(verdict: Verdict) -> list[str]:
    """Return a verdict as lines of plain words."""
    return [
        f"{verdict.grade.upper()}: corners of {verdict.pictures} photos miss their places by {verdict.rms_px:.2f} px (rms)",
        f"the board was seen to {verdict.seen_to_deg:.0f} degrees from the axis, {verdict.reach:.0%} of the way to the border of the field",
        f"a point 1 m away is placed wrong by {1e3 * verdict.error_at_1m_m:.1f} mm at most (one standard deviation)",
        *(f"  but: {reason}" for reason in verdict.reasons),
        *(f"  so: {advice}" for advice in verdict.advice),
    ]
