"""What `ommatidia calibrate rig` does, with somebody at the terminal."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

import yaml
from rich.console import Console
from rich.markup import escape
from rich.progress import Progress

from agent.calibration import read_calibration
from agent.config import AgentConfig, load_config
from agent.rig import Calibration
from deploy.bodies import drawn_body
from deploy.calibration.rig import LEAST_TAPE_M, MOST_TAPE_M, Watched, calibration_of, found_rig
from deploy.calibration.rig_drive import LEGS, check_nobody_leads, drive_robot, figure
from deploy.calibration.rig_live import FIGURE, watch_pushed
from deploy.calibration.rig_recording import recorded_robot, watch_recording, without_rim
from deploy.calibration.rig_table import tell_rig
from protocol.bus import Bus
from protocol.errors import ConfigError
from sim.recording import RecordedRobot, Recording

CONNECT_TIMEOUT_S = 2.0


class Wishes(NamedTuple):
    """What was asked for on the command line: a recording and a robot in it, or the settings of an agent that runs."""

    recording: Path | None
    robot: str | None
    config: Path | None
    drives: bool  # the robot that runs, by itself
    seconds_s: float
    distance_m: float | None
    out: Path
    overwrite: bool


def calibrate_rig_of(wishes: Wishes, console: Console) -> None:
    """Find the rig of a robot; leave sensor.yaml in a folder where lengths are known. Raises OmmatidiaError."""
    sensor_file = wishes.out / "sensor.yaml"
    if sensor_file.exists() and not wishes.overwrite:
        raise ConfigError(f"{sensor_file}: is there already; replace it with --overwrite, or name another folder with --out")
    _check_agree(wishes)
    drawn_file, watched = _watch(wishes, console)
    by_tape_m = read_tape(console) if wishes.drives and not watched.shows_length else wishes.distance_m
    rig = found_rig(watched, by_tape_m)
    tell_rig(rig, watched, console)
    if not rig.has_scale:
        console.print("no length is known: these are ratios to the camera height as drawn, and no file is written.")
        console.print("State deck_radius_m and deck_height_m, or push the robot along a tape and say --distance.", soft_wrap=True)
        return
    wishes.out.mkdir(parents=True, exist_ok=True)
    write_rig_file(drawn_file, calibration_of(rig, read_calibration(drawn_file)), sensor_file)
    console.print(f"camera: {sensor_file}", soft_wrap=True)
    radius_m = 0.5 * (rig["wheel_radius_left_m"] + rig["wheel_radius_right_m"])
    console.print("wheels, for [body] of the agent's file:", highlight=False, markup=False)
    console.print(f"  wheel_base_m = {rig['wheel_base_m']:.5f}\n  wheel_radius_m = {radius_m:.6f}", highlight=False)


def read_tape(console: Console) -> float | None:
    """Ask how far the robot went; None where nobody knows."""
    while True:
        try:
            told = console.input("Metres from where it began to where it stands, by a tape (Enter: not known): ").strip()
        except EOFError:
            return None
        if not told:
            return None
        with suppress(ValueError):  # it is said below
            if LEAST_TAPE_M <= (distance_m := float(told)) <= MOST_TAPE_M:
                return distance_m
        console.print(f"Say it in metres, from {LEAST_TAPE_M:g} to {MOST_TAPE_M:g}, like 1.013.", highlight=False)


def _check_agree(wishes: Wishes) -> None:
    """Raise ConfigError where a drive was asked for together with what does not go with it."""
    if wishes.drives and wishes.recording is not None:
        raise ConfigError("--drive: moves a robot that runs: name it with --config, in place of --recording")
    if wishes.drives and wishes.distance_m is not None:
        raise ConfigError("--distance: leave it out with --drive, which asks what the tape says once the robot stands, if it has to know")


def write_rig_file(drawn_file: Path, calibration: Calibration, file: Path) -> None:
    """Write a sensor.yaml that says what the drawn one does, but for mount, focal length and lens centre."""
    document = yaml.safe_load(drawn_file.read_text(encoding="utf-8"))
    document["intrinsics"] = [round(float(value), 4) for value in (*calibration.focal_px, *calibration.centre_px)]
    document["T_BS"] = {"rows": 4, "cols": 4, "data": [round(float(value), 9) for value in calibration.body_from_camera.ravel()]}
    file.write_text(yaml.safe_dump(document, sort_keys=False, default_flow_style=None, width=120), encoding="utf-8")
    read_calibration(file)


def _watch(wishes: Wishes, console: Console) -> tuple[Path, Watched]:
    """Return the calibration that the robot was drawn with, and what it has learned while it moved."""
    if wishes.recording is not None and wishes.config is None:
        robot = recorded_robot(Recording.open(wishes.recording), wishes.robot)
        return robot.sensor_file, _watch_recorded(robot, console, shows_rim=wishes.distance_m is None)
    if wishes.config is not None and wishes.recording is None:
        config = load_config(wishes.config)
        read_calibration(config.camera.calibration)  # complains before anybody has pushed for nothing
        watched = _watch_driven(config, wishes.out, console) if wishes.drives else _watch_running(config, wishes.seconds_s, console)
        return config.camera.calibration, watched
    raise ConfigError("name either a drive with --recording, or a robot that runs with --config")


def _watch_recorded(robot: RecordedRobot, console: Console, *, shows_rim: bool) -> Watched:
    drawn = read_calibration(robot.sensor_file)
    with Progress(console=console, transient=True) as bar:
        task = bar.add_task(f"{robot.name}: looking at the floor", total=len(robot.camera))
        body = drawn_body(robot.rig)
        return watch_recording(robot, body if shows_rim else without_rim(body), drawn, lambda: bar.advance(task))


def _watch_running(config: AgentConfig, seconds_s: float, console: Console) -> Watched:
    for line in FIGURE:
        console.print(line, soft_wrap=True)
    with (
        Bus.open_client(config.robot.site, config.robot.endpoint, CONNECT_TIMEOUT_S) as bus,
        Progress(console=console, transient=True) as bar,
    ):
        task = bar.add_task(f"{config.robot.name}: watching", total=seconds_s)
        return watch_pushed(bus, config.robot.name, seconds_s, lambda passed_s: bar.update(task, completed=passed_s))


def _watch_driven(config: AgentConfig, folder: Path, console: Console) -> Watched:
    """Have the robot drive once somebody has said so."""
    check_nobody_leads(config)
    for line in figure(config):
        console.print(line, soft_wrap=True)
    try:
        console.input("Press Enter to let it drive. ")
    except EOFError:
        raise ConfigError("--drive: nobody is here to say that the robot may drive; press Enter where it asks") from None
    with Progress(console=console, transient=True) as bar:
        task = bar.add_task(f"{config.robot.name}: waiting for it", total=LEGS)

        def show(legs: int, doing: str) -> None:
            bar.update(task, completed=legs, description=f"{config.robot.name}: {escape(doing)}")

        return drive_robot(config, folder, show)
