"""The configuration of a robot without a camera: one TOML file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from pydantic import Field

from agent.range_bearing.dead_reckoning import MotionNoise
from agent.range_bearing.method import SightingNoise
from protocol.fields import Name
from protocol.settings import Endpoint, Settings, load_toml

Share = Annotated[float, Field(ge=0.0, le=1.0, allow_inf_nan=False)]


class RobotSettings(Settings):
    """Who the robot is, and where its map server is."""

    name: Name
    site: Name = "home"
    endpoint: Endpoint
    body_radius_m: Annotated[float, Field(gt=0.0, le=5.0, allow_inf_nan=False)] = 0.17


class BaseSettings(Settings):
    """The driven base: how soon it follows, and how well its speeds tell where it gets to."""

    response_s: Annotated[float, Field(ge=0.0, le=2.0, allow_inf_nan=False)] = 0.0
    forward_share: Share = 0.1
    side_share: Share = 0.05
    turn_share: Share = 0.1
    walk_m_sqrt_s: Share = 0.01
    walk_rad_sqrt_s: Share = 0.04

    def noise(self) -> MotionNoise:
        """Return what dead reckoning errs by."""
        return MotionNoise(**self.model_dump(exclude={"response_s"}))


class SensorSettings(Settings):
    """The range-bearing sensor."""

    driver: str = "bus"
    endpoint: Endpoint
    range_m: Annotated[float, Field(gt=0.0, le=10.0, allow_inf_nan=False)] = 0.05
    range_share: Share = 0.05
    bearing_rad: Annotated[float, Field(gt=0.0, le=1.0, allow_inf_nan=False)] = 0.01
    target_m_s: Annotated[float, Field(ge=0.0, le=10.0, allow_inf_nan=False)] = 0.05  # of another robot, along one axis

    def noise(self) -> SightingNoise:
        """Return what the sensor errs by."""
        return SightingNoise(**self.model_dump(exclude={"driver", "endpoint"}))


class RangeBearingConfig(Settings):
    """The whole file."""

    robot: RobotSettings
    base: BaseSettings = BaseSettings()
    sensor: SensorSettings


def load_config(file: Path) -> RangeBearingConfig:
    """Return the configuration; raises ConfigError that names file and field."""
    return load_toml(file, RangeBearingConfig)
