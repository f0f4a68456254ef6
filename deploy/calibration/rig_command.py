"""What `ommatidia calibrate rig` does, with somebody at the terminal."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import yaml
from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from agent.calibration import read_calibration
from agent.config import AgentConfig, load_config
from agent.rig import Calibration
from deploy.bodies import drawn_body
from deploy.calibration.rig import FoundRig, Watched, calibration_of, found_rig
from deploy.calibration.rig_live import FIGURE, watch_robot
from deploy.calibration.rig_recording import recorded_robot, watch_recording, without_rim
from protocol.bus import Bus
from protocol.errors import ConfigError
from sim.recording import RecordedRobot, Recording

CONNECT_TIMEOUT_S = 2.0
_ROWS = (  # name, what it is called, unit, how many of it are one of the value's
    ("camera_height_m", "camera height", "mm", 1e3),
    ("camera_tilt_forward_rad", "tilt forward", "mrad", 1e3),
    ("camera_tilt_left_rad", "tilt left", "mrad", 1e3),
    ("camera_offset_x_m", "camera ahead of the axle", "mm", 1e3),
    ("camera_offset_y_m", "camera left of the middle", "mm", 1e3),
    ("centre_u_px", "lens centre u", "px", 1.0),
    ("centre_v_px", "lens centre v", "px", 1.0),
    ("focal_px", "focal length", "px/rad", 1.0),
    ("wheel_radius_left_m", "left wheel's radius", "mm", 1e3),
    ("wheel_radius_right_m", "right wheel's radius", "mm", 1e3),
    ("wheel_base_m", "wheel base", "mm", 1e3),
    ("wheel_lag_s", "wheel stamps late by", "ms", 1e3),
)


class Wishes(NamedTuple):
    """What was asked for on the command line: a recording and a robot in it, or the settings of an agent that runs."""

    recording: Path | None
    robot: str | None
    config: Path | None
    seconds_s: float
    distance_m: float | None
    out: Path
    overwrite: bool


def calibrate_rig_of(wishes: Wishes, console: Console) -> None:
    """Find the rig of a robot; leave sensor.yaml in a folder where lengths are known. Raises OmmatidiaError."""
    sensor_file = wishes.out / "sensor.yaml"
    if sensor_file.exists() and not wishes.overwrite:
        raise ConfigError(f"{sensor_file}: is there already; replace it with --overwrite, or name another folder with --out")
    drawn_file, watched = _watch(wishes, console)
    rig = found_rig(watched, wishes.distance_m)
    _tell(rig, watched, console)
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
        return config.camera.calibration, _watch_running(config, wishes.seconds_s, console)
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
        return watch_robot(bus, config.robot.name, seconds_s, lambda passed_s: bar.update(task, completed=passed_s))


def _tell(rig: FoundRig, watched: Watched, console: Console) -> None:
    """Say what was found, how sure that is, and what would make it surer."""
    table = Table(title=f"the rig, from {watched.pictures} pictures")
    for heading in ("", "found", "+-", ""):
        table.add_column(heading, justify="left" if heading == "" else "right")
    for name, called, unit, per_unit in _ROWS:
        table.add_row(called, *_row(rig, name, unit, per_unit))
    console.print(table)
    for advice in rig.advice:
        console.print(f"  not sure enough yet: {advice}", highlight=False)


def _row(rig: FoundRig, name: str, unit: str, per_unit: float) -> tuple[str, str, str]:
    """Return a value, its uncertainty and its unit; a length without scale as a ratio."""
    value = rig.values.get(name)
    if value is None:
        value, unit, per_unit = rig.values[name.removesuffix("_m") + "_camera_heights"], "camera heights", 1.0
    sigma = "as drawn" if value.sigma is None else f"{per_unit * value.sigma:.4g}"
    return f"{per_unit * value.value:.5g}", sigma, unit
