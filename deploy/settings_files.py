"""The settings files of a run, kept in its folder: what a person would write by hand, made from what is told of the robots."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Protocol

import tomli_w

from agent.calibration import read_calibration
from agent.config import AgentConfig
from agent.pipeline import Method
from agent.range_bearing.config import RangeBearingConfig
from deploy.bodies import LENGTHS
from mapserver.config import MapServerConfig
from protocol.errors import ConfigError
from protocol.settings import Settings, parse
from sim.rigs import RIGS_FILE, RobotRig

SITE = "swarm"
MAP_SERVER, WORLD = "mapserver", "world"  # names of processes: settings and logs of all lie side by side
PROCESSES = {MAP_SERVER, WORLD}
NOBODY_MOVES: Mapping[str, object] = MappingProxyType({})

CREATE_RADIUS_M = 0.17
CREATE_RESPONSE_S = 0.1
# Sightings to a few centimetres are worth no finer solution; robots that nobody leads are held up by no pause, so old poses may stay.
CENTIMETRES: Mapping[str, object] = MappingProxyType(
    {"relinearise_above": 0.05, "relinearise_every": 10, "extra_iterations": 0, "most_poses": 12_000, "kept_poses": 9_000}
)

_START = {"name", "initial_pose", "initial_pose_sigma", "body_radius_m"}


class TeamRobot(Protocol):
    """What is told of one robot."""

    @property
    def name(self) -> str:
        """Its name."""
        ...

    @property
    def rig(self) -> RobotRig:
        """How it is built, and where it starts."""
        ...

    @property
    def sensor_file(self) -> Path:
        """The calibration of its camera."""
        ...


class Team(Protocol):
    """What is told of all robots: by a recording, or by a simulated world."""

    @property
    def folder(self) -> Path:
        """Where it is told."""
        ...

    @property
    def robots(self) -> Sequence[TeamRobot]:
        """One by one."""
        ...


def check_robots(team: Team) -> None:
    """Raise ConfigError, before any process is started, where a robot's name or its camera's calibration cannot be used."""
    for robot in team.robots:
        if robot.name in PROCESSES:
            raise ConfigError(f"{team.folder / RIGS_FILE}: no robot can be named {robot.name}, as the {robot.name}'s process is")
        read_calibration(robot.sensor_file)


def agent_settings(team: Team, robot: TeamRobot, method: Method, swarm_endpoint: str, world_endpoint: str) -> AgentConfig:
    """Return the settings of a robot's agent, whose camera and wheels are in the world at `world_endpoint`. Raises ConfigError."""
    document = {
        "robot": {"name": robot.name, "site": SITE, "endpoint": swarm_endpoint, "method": method},
        "body": robot.rig.model_dump(include=LENGTHS),
        "camera": {"endpoint": world_endpoint, "calibration": str(robot.sensor_file.absolute())},
        "wheels": {"endpoint": world_endpoint},
    }
    return parse(team.folder / RIGS_FILE, document, AgentConfig)


def mapserver_settings(team: Team, formation: Mapping[str, object] = NOBODY_MOVES) -> MapServerConfig:
    """Return the settings of a swarm's map server: a free port, the world's clock, and its formation. Raises ConfigError."""
    robots = [robot.rig.model_dump(include=_START) for robot in team.robots]
    document = {"site": SITE, "clock": "world", "robots": robots, "formation": dict(formation)}
    return parse(team.folder / RIGS_FILE, document, MapServerConfig)


def readings_agent_settings(folder: Path, robot: str, swarm_endpoint: str, world_endpoint: str) -> RangeBearingConfig:
    """Return the settings of a robot of the UTIAS data set, which lies in `folder`.

    Its base is an iRobot Create, which follows commanded speeds after about 0.1 s.
    """
    document = {
        "robot": {"name": robot, "site": SITE, "endpoint": swarm_endpoint, "body_radius_m": CREATE_RADIUS_M},
        "base": {"response_s": CREATE_RESPONSE_S},
        "sensor": {"endpoint": world_endpoint},
    }
    return parse(folder, document, RangeBearingConfig)


def readings_server_settings(folder: Path, robots: Sequence[str]) -> MapServerConfig:
    """Return the settings of a map server for robots without cameras; the first of them makes the arena's origin where it begins."""
    starts = {robots[0]: {"initial_pose": [0.0, 0.0, 0.0]}}
    document = {
        "site": SITE,
        "clock": "world",
        "robots": [{"name": robot, "body_radius_m": CREATE_RADIUS_M, **starts.get(robot, {})} for robot in robots],
        "formation": {"distance_m": 4.0 * CREATE_RADIUS_M},  # nobody is moved, but it has to be possible
        "graph": dict(CENTIMETRES),
    }
    return parse(folder, document, MapServerConfig)


def write_settings(folder: Path, process: str, settings: Settings) -> Path:
    """Write the settings of a process to `folder`/<process>.toml, and return where they are."""
    folder.mkdir(exist_ok=True)
    file = (folder / f"{process}.toml").absolute()
    document = settings.model_dump(mode="json", exclude_none=True)
    file.write_text(tomli_w.dumps(document), encoding="utf-8")
    return file
