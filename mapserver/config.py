"""The map server's configuration: one TOML file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from mapserver.mapping.pose_graph import Start
from protocol.geometry import Pose2
from protocol.messages import Name
from protocol.settings import Settings, load_toml

MAX_ROBOTS = 64  # a local map has room for as many sightings

Coordinate = Annotated[float, Field(ge=-1e4, le=1e4, allow_inf_nan=False)]
Sigma = Annotated[float, Field(ge=0.0, le=1e2, allow_inf_nan=False)]


class RobotSettings(Settings):
    """One robot of the swarm, and where it is set down."""

    name: Name
    initial_pose: tuple[Coordinate, Coordinate, Coordinate]  # [m, m, rad; arena]
    initial_pose_sigma: tuple[Sigma, Sigma, Sigma] = (0.0, 0.0, 0.0)  # standard deviations [m, m, rad; arena]; 0: exact
    body_radius_m: Annotated[float, Field(gt=0.0, le=5.0, allow_inf_nan=False)] = 0.075

    def start(self) -> Start:
        """Return where the robot begins."""
        return Start(Pose2(*self.initial_pose), self.initial_pose_sigma)


class MapServerConfig(Settings):
    """The whole file."""

    site: Name = "home"
    listen: Annotated[str, Field(pattern=r"^(tcp|tls)/[^/\s]+:\d{1,5}$")] = "tcp/127.0.0.1:0"  # port 0: a free one, told when ready
    clock: Literal["wall", "world"] = "wall"  # world: steps wait for the stamps that a replayed or simulated world announces
    robots: Annotated[tuple[RobotSettings, ...], Field(min_length=1, max_length=MAX_ROBOTS)]

    @model_validator(mode="after")
    def _names_differ(self) -> Self:
        names = [robot.name for robot in self.robots]
        if twice := sorted({name for name in names if names.count(name) > 1}):
            raise ValueError(f"robots need names of their own, but {', '.join(twice)} is there more than once")
        return self


def load_config(file: Path) -> MapServerConfig:
    """Return the configuration; raises ConfigError that names file and field."""
    return load_toml(file, MapServerConfig)
