"""The settings files of a run: what a person would write by hand for each process, made from a recording and kept in the run's folder."""

from __future__ import annotations

from pathlib import Path

import tomli_w

from agent.calibration import read_calibration
from agent.config import AgentConfig
from agent.pipeline import Method
from mapserver.config import MapServerConfig
from protocol.errors import ConfigError
from protocol.settings import Settings, parse
from sim.recording import RecordedRobot, Recording
from sim.rigs import RIGS_FILE

SITE = "replay"
MAP_SERVER = "mapserver"  # the process's name: settings and logs of all processes lie side by side

_BODY = {"body_radius_m", "body_height_m", "wheel_base_m", "wheel_radius_m"}
_START = {"name", "initial_pose", "initial_pose_sigma", "body_radius_m"}


def check_robots(recording: Recording) -> None:
    """Raise ConfigError, before any process is started, where a robot's name or its camera's calibration cannot be used."""
    if MAP_SERVER in recording.names:
        raise ConfigError(f"{recording.folder / RIGS_FILE}: no robot can be named {MAP_SERVER}, as the map server's process is")
    for robot in recording.robots:
        read_calibration(robot.sensor_file)


def agent_settings(recording: Recording, robot: RecordedRobot, method: Method, swarm_endpoint: str, world_endpoint: str) -> AgentConfig:
    """Return the settings of a recorded robot's agent, whose camera and wheels are in the world at `world_endpoint`. Raises ConfigError."""
    document = {
        "robot": {"name": robot.name, "site": SITE, "endpoint": swarm_endpoint, "method": method},
        "body": robot.rig.model_dump(include=_BODY),
        "camera": {"endpoint": world_endpoint, "calibration": str(robot.sensor_file.absolute())},
        "wheels": {"endpoint": world_endpoint},
    }
    return parse(recording.folder / RIGS_FILE, document, AgentConfig)


def mapserver_settings(recording: Recording) -> MapServerConfig:
    """Return the settings of a recorded swarm's map server: a free port, and the recording's clock. Raises ConfigError."""
    robots = [robot.rig.model_dump(include=_START) for robot in recording.robots]
    return parse(recording.folder / RIGS_FILE, {"site": SITE, "clock": "world", "robots": robots}, MapServerConfig)


def write_settings(folder: Path, process: str, settings: Settings) -> Path:
    """Write the settings of a process to `folder`/<process>.toml, and return where they are."""
    folder.mkdir(exist_ok=True)
    file = (folder / f"{process}.toml").absolute()
    document = settings.model_dump(mode="json", exclude_none=True)
    file.write_text(tomli_w.dumps(document), encoding="utf-8")
    return file
