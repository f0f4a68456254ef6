"""The agent's configuration file."""

from __future__ import annotations

from pathlib import Path

import pytest

from agent.config import (
    BusWheelSettings,
    Create2Settings,
    RosArduinoBridgeSettings,
    V4l2CameraSettings,
    VideoFileSettings,
    load_config,
)
from agent.control.limits import DriveLimits
from agent.rig import Body
from protocol.errors import ConfigError

SHORTEST = """\
[robot]
name = "r1"
endpoint = "tcp/127.0.0.1:7447"
[camera]
endpoint = "tcp/127.0.0.1:7448"
calibration = "r1/sensor.yaml"
[wheels]
endpoint = "tcp/127.0.0.1:7448"
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    file = tmp_path / "r1.toml"
    file.write_text(SHORTEST)
    return file


def test_what_only_the_owner_knows_is_enough(file: Path) -> None:
    config = load_config(file)
    assert (config.robot.method, config.robot.site, config.camera.driver) == ("full", "home", "bus")
    assert config.drive.limits() == DriveLimits()
    assert config.drive.margin_m == 0.02
    assert config.body.body() == Body(body_radius_m=0.075, body_height_m=0.30, wheel_base_m=0.12, wheel_radius_m=0.03)


def test_calibration_is_found_beside_the_configuration_file(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(file.parent.parent)
    assert load_config(file.relative_to(file.parent.parent)).camera.calibration == file.parent / "r1" / "sensor.yaml"


def test_absolute_calibration_path_is_kept(file: Path) -> None:
    file.write_text(SHORTEST.replace("r1/sensor.yaml", "/etc/ommatidia/sensor.yaml"))
    assert load_config(file).camera.calibration == Path("/etc/ommatidia/sensor.yaml")


@pytest.mark.parametrize(
    ("old", "new", "field"),
    [
        ('name = "r1"', 'name = "R 1"', "robot.name"),
        ('name = "r1"', 'name = "r1"\nmethod = "fast"', "robot.method"),
        ("tcp/127.0.0.1:7447", "127.0.0.1:7447", "robot.endpoint"),
        ("[wheels]", '[wheels]\ndriver = "arduino"', "wheels.driver"),
        ("[camera]", '[camera]\ndriver = "webcam"', "camera.driver"),
        ("[wheels]", "[body]\nwheel_base_m = -0.12\n[wheels]", "body.wheel_base_m"),
        ("[wheels]", "[drive]\nmax_speed_m_s = 0.0\n[wheels]", "drive.max_speed_m_s"),
        ("[wheels]", "[drive]\nmax_wheel_rad_s = inf\n[wheels]", "drive.max_wheel_rad_s"),
        ("[wheels]", "[drive]\nmargin_m = -0.02\n[wheels]", "drive.margin_m"),
        ("[wheels]", "[body]\nbody_radius_m = 75\n[wheels]", "body.body_radius_m"),
    ],
)
def test_unusable_value_is_refused_with_file_and_field(file: Path, old: str, new: str, field: str) -> None:
    file.write_text(SHORTEST.replace(old, new, 1))
    with pytest.raises(ConfigError, match=rf"r1\.toml: `{field}`: "):
        load_config(file)


def test_cameras_of_a_robot_are_named_by_their_driver(file: Path) -> None:
    file.write_text(SHORTEST.replace('endpoint = "tcp/127.0.0.1:7448"', 'driver = "v4l2"\nexposure_s = 0', 1))
    camera = load_config(file).camera
    assert isinstance(camera, V4l2CameraSettings)
    assert (camera.device, camera.exposure_s, camera.white_balance_k) == (Path("/dev/ommatidia/camera"), 0.0, 4600)


def test_film_is_found_beside_the_configuration_file(file: Path) -> None:
    file.write_text(SHORTEST.replace('endpoint = "tcp/127.0.0.1:7448"', 'driver = "video"\nfile = "film.avi"', 1))
    camera = load_config(file).camera
    assert isinstance(camera, VideoFileSettings)
    assert camera.file == file.parent / "film.avi"


def test_limits_of_the_drive_are_read(file: Path) -> None:
    file.write_text(SHORTEST + "[drive]\nmax_speed_m_s = 0.1\nmargin_m = 0.05\n")
    assert load_config(file).drive.limits() == DriveLimits(max_speed_m_s=0.1)
    assert load_config(file).drive.margin_m == 0.05


def test_unknown_key_is_refused_with_the_nearest_known_one(file: Path) -> None:
    file.write_text(SHORTEST.replace("calibration", "calibratoin"))
    with pytest.raises(ConfigError, match=r"unknown key `camera\.calibratoin`; did you mean `calibration`\?"):
        load_config(file)


def test_unknown_key_of_a_camera_is_refused_with_the_nearest_one_of_that_camera(file: Path) -> None:
    file.write_text(SHORTEST.replace('endpoint = "tcp/127.0.0.1:7448"', 'driver = "v4l2"\nexposure = 0.01', 1))
    with pytest.raises(ConfigError, match=r"unknown key `camera\.exposure`; did you mean `exposure_s`\?"):
        load_config(file)


def test_wheels_are_on_the_bus_where_no_driver_is_named(file: Path) -> None:
    assert load_config(file).wheels == BusWheelSettings(driver="bus", endpoint="tcp/127.0.0.1:7448")


def wheels(file: Path, table: str) -> Path:
    file.write_text(SHORTEST[: SHORTEST.index("[wheels]")] + table)
    return file


def test_a_serial_driver_needs_its_name_only(file: Path) -> None:
    assert load_config(wheels(file, '[wheels]\ndriver = "create2"')).wheels == Create2Settings(driver="create2", baud=115200)
    board = load_config(wheels(file, '[wheels]\ndriver = "ros_arduino_bridge"\npid = [20, 12, 0, 50]')).wheels
    assert board == RosArduinoBridgeSettings(driver="ros_arduino_bridge", pid=(20, 12, 0, 50))


@pytest.mark.parametrize(
    ("table", "complaint"),
    [
        ('driver = "create2"\nprot = "/dev/ttyUSB0"', r"unknown key `wheels\.prot`; did you mean `port`\?"),
        ('driver = "create2"\npid_rate_hz = 30', r"unknown key `wheels\.pid_rate_hz`; known here: baud, driver, port"),
        ('driver = "create3"', r"`wheels\.driver`: expected one of 'bus', 'ros_arduino_bridge', 'create2', not 'create3'"),
        ('driver = "ros_arduino_bridge"\npid = [20, 12, 0, 0]', r"`wheels\.pid\[3\]`: "),
        ('driver = "ros_arduino_bridge"\nport = "COM3"', r"`wheels\.port`: "),
        ("", r"`wheels\.endpoint` is missing"),
    ],
)
def test_wheels_that_cannot_be_are_refused_as_they_stand_in_the_file(file: Path, table: str, complaint: str) -> None:
    with pytest.raises(ConfigError, match=complaint):
        load_config(wheels(file, f"[wheels]\n{table}\n"))
