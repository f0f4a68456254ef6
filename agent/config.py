"""The agent's configuration: one TOML file, whose every key has its default here unless only the owner can know it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from pydantic import BeforeValidator, Field

from agent.control.limits import DriveLimits
from agent.rig import Body
from protocol.fields import Name
from protocol.settings import Endpoint, Settings, load_toml

Limit = Annotated[float, Field(gt=0.0, le=100.0, allow_inf_nan=False)]
Length = Annotated[float, Field(gt=0.0, le=5.0, allow_inf_nan=False)]  # [m]; no robot here is larger

Port = Annotated[str, Field(pattern=r"^/.")]  # a serial port's device file
Baud = Annotated[int, Field(ge=1200, le=4_000_000)]
Gain = Annotated[int, Field(ge=0, le=32767)]  # what an int of the board holds
Divisor = Annotated[int, Field(ge=1, le=32767)]
PidGains = Annotated[tuple[Gain, Gain, Gain, Divisor], Field(strict=False)]  # a list in the file


Rate = Annotated[float, Field(gt=0.0, le=240.0, allow_inf_nan=False)]
Exposure = Annotated[float, Field(ge=0.0, le=1.0, allow_inf_nan=False)]
ColourGain = Annotated[float, Field(ge=0.0, le=32.0, allow_inf_nan=False)]


def _on_the_bus(table: object) -> object:
    """Name the driver of a table that names none."""
    return {"driver": "bus", **table} if isinstance(table, dict) else table


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


class BusCameraSettings(Settings):
    """A camera in a world on the other side of a bus: a recording's, or a rendered one's."""

    driver: Literal["bus"] = "bus"
    endpoint: Endpoint
    calibration: Path  # sensor.yaml, relative to the configuration file


class V4l2CameraSettings(Settings):
    """A camera behind Video4Linux: USB, or a board's own. It is asked for pictures of the calibration's size."""

    driver: Literal["v4l2"]
    calibration: Path
    device: Path = Path("/dev/ommatidia/camera")  # a name that stays: of a udev rule, or below /dev/v4l/by-id
    rate_hz: Rate = 10.0  # more than the agent can take costs time and tells nothing: it sees the newest frame only
    mjpg: bool = True  # compressed by the camera: several cameras, or large pictures, are too much for one USB bus otherwise
    exposure_s: Exposure = 0.01  # 0: the camera's own choice. Fixed keeps the floor's brightness; 0.01 and 0.02 do not flicker at 50 Hz
    white_balance_k: Annotated[int, Field(ge=0, le=20_000)] = 4600  # 0: the camera's own choice, by which colours drift


class PiCameraSettings(Settings):
    """A Raspberry Pi's camera on its ribbon cable, by the package picamera2, which Raspberry Pi OS brings along."""

    driver: Literal["picamera2"]
    calibration: Path
    number: Annotated[int, Field(ge=0, le=7)] = 0  # as `rpicam-hello --list-cameras` counts them
    rate_hz: Rate = 10.0
    exposure_s: Exposure = 0.01  # 0: the camera's own choice, of the gain too
    gain: Annotated[float, Field(ge=1.0, le=64.0, allow_inf_nan=False)] = 4.0
    red_gain: ColourGain = 0.0  # both 0: the camera's own white balance
    blue_gain: ColourGain = 0.0


class VideoFileSettings(Settings):
    """A film, played once in its own time."""

    driver: Literal["video"]
    calibration: Path
    file: Path  # relative to the configuration file


LocalCameraSettings = V4l2CameraSettings | PiCameraSettings | VideoFileSettings
CameraSettings = Annotated[BusCameraSettings | LocalCameraSettings, Field(discriminator="driver"), BeforeValidator(_on_the_bus)]


class BusWheelSettings(Settings):
    """Wheels of a recorded or simulated world."""

    driver: Literal["bus"] = "bus"
    endpoint: Endpoint


class RosArduinoBridgeSettings(Settings):
    """Wheels behind a board with the ROSArduinoBridge firmware; the defaults are those of the firmware and of the building manual."""

    driver: Literal["ros_arduino_bridge"]
    port: Port = "/dev/ommatidia/wheels"
    baud: Baud = 57600  # BAUDRATE in the firmware
    ticks_per_revolution: Annotated[float, Field(gt=0.0, le=1e6, allow_inf_nan=False)] = 1920.0  # of a wheel: counts times gear ratio
    pid_rate_hz: Annotated[int, Field(ge=1, le=1000)] = 30  # PID_RATE in the firmware
    pid: PidGains | None = None  # Kp, Kd, Ki, Ko; without them the firmware keeps its own
    settle_s: Annotated[float, Field(ge=0.0, le=10.0, allow_inf_nan=False)] = 2.0  # most boards restart when it is opened


class Create2Settings(Settings):
    """Wheels of an iRobot Create 2, or of a Roomba of the 600 series. Its body wants wheel_radius_m = 0.036, wheel_base_m = 0.235."""

    driver: Literal["create2"]
    port: Port = "/dev/ommatidia/wheels"
    baud: Baud = 115200  # the other speed that it may have been set to: 19200


SerialWheelSettings = RosArduinoBridgeSettings | Create2Settings
WheelSettings = Annotated[BusWheelSettings | SerialWheelSettings, Field(discriminator="driver"), BeforeValidator(_on_the_bus)]


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
    """Return the configuration, the paths of the camera's files made absolute; raises ConfigError that names file and field."""
    config = load_toml(file, AgentConfig)
    camera, folder = config.camera, file.absolute().parent
    files = {"calibration": folder / camera.calibration}
    if isinstance(camera, VideoFileSettings):
        files["file"] = folder / camera.file
    return config.model_copy(update={"camera": camera.model_copy(update=files)})
