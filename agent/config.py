"""The agent's configuration: one TOML file, whose every key has its default here unless only the owner can know it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from agent.control.limits import DriveLimits
from agent.rig import Body
from protocol.fields import Name
from protocol.settings import Settings, load_toml

Endpoint = Annotated[str, Field(pattern=r"^(tcp|tls)/[^/\s]+:\d{1,5}$")]  # such as tcp/192.168.1.20:7447
Limit = Annotated[float, Field(gt=0.0, le=100.0, allow_inf_nan=False)]
Length = Annotated[float, Field(gt=0.0, le=5.0, allow_inf_nan=False)]  # [m]; no robot here is larger


class RobotSettings(Settings):
    """Who the robot is, and where its map server is."""

    name: Name
    site: Name = "home"
    endpoint: Endpoint
    method: Literal["full", "paper", "paper-calibrated"] = "full"


class BodySettings(Settings):
    """The lengths of the robot's body [m]; the defaults are those of the robot in the building manual."""

    body_radius_m: Length = 0.075
    body_height_m: Length = 0.30
    wheel_base_m: Length = 0.12
    wheel_radius_m: Length = 0.03
    deck_radius_m: Length | None = None  # with its height: the camera finds its own height and tilt by the deck's edge
    deck_height_m: Length | None = None

    def body(self) -> Body:
        """Return the lengths as the estimator takes them."""
        return Body(**self.model_dump())


class CameraSettings(Settings):
    """Where frames come from, and the lens they were taken through."""

    driver: Literal["bus"] = "bus"
    endpoint: Endpoint
    calibration: Path  # sensor.yaml, relative to the configuration file


class WheelSettings(Settings):
    """Where the wheels are."""

    driver: Literal["bus"] = "bus"
    endpoint: Endpoint


class DriveSettings(Settings):
    """What the robot may do, and how far it keeps from things; the defaults suit the robot in the building manual."""

    max_speed_m_s: Limit = 0.25
    max_turn_rad_s: Limit = 2.5
    max_wheel_rad_s: Limit = 12.0
    max_acceleration_m_s2: Limit = 0.6
    max_turn_acceleration_rad_s2: Limit = 12.0
    margin_m: Annotated[float, Field(ge=0.0, le=1.0, allow_inf_nan=False)] = 0.02

    def limits(self) -> DriveLimits:
        """Return the limits as the controller takes them."""
        return DriveLimits(**self.model_dump(exclude={"margin_m"}))


class AgentConfig(Settings):
    """The whole file."""

    robot: RobotSettings
    body: BodySettings = BodySettings()
    camera: CameraSettings
    wheels: WheelSettings
    drive: DriveSettings = DriveSettings()


def load_config(file: Path) -> AgentConfig:
    """Return the configuration, the calibration's path made absolute; raises ConfigError that names file and field."""
    config = load_toml(file, AgentConfig)
    calibration = file.absolute().parent / config.camera.calibration
    return config.model_copy(update={"camera": config.camera.model_copy(update={"calibration": calibration})})
