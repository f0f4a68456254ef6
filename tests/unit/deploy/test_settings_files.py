"""Settings files made from a recording: what the services read back is what the recording tells."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest

from agent.config import BusCameraSettings, BusWheelSettings
from agent.config import load_config as load_agent
from deploy.settings_files import agent_settings, check_robots, mapserver_settings, write_settings
from mapserver.config import load_config as load_mapserver
from protocol.errors import ConfigError
from sim.recording import Recording

EXCERPT = Path(__file__).parents[2] / "data" / "excerpt"
SWARM, WORLD = "tcp/127.0.0.1:7001", "tcp/127.0.0.1:7002"


@pytest.fixture
def recording() -> Recording:
    return Recording.open(EXCERPT)


def test_an_agent_reads_back_its_body_its_links_and_its_calibration(recording: Recording, tmp_path: Path) -> None:
    robot = recording.robots[1]
    settings = load_agent(write_settings(tmp_path / "config", "r2", agent_settings(recording, robot, "paper", SWARM, WORLD)))
    assert (settings.robot.name, settings.robot.endpoint, settings.robot.method) == ("r2", SWARM, "paper")
    assert isinstance(settings.camera, BusCameraSettings)
    assert (settings.camera.endpoint, settings.wheels) == (WORLD, BusWheelSettings(endpoint=WORLD))
    assert settings.camera.calibration == EXCERPT / "r2" / "cam0" / "sensor.yaml"
    assert settings.body.wheel_base_m == robot.rig.wheel_base_m
    assert settings.body.wheel_radius_m == robot.rig.wheel_radius_m
    assert settings.body.body_radius_m == robot.rig.body_radius_m
    assert settings.body.body_height_m == robot.rig.body_height_m


def test_the_map_server_reads_back_where_every_robot_starts_and_how_sure_that_is(recording: Recording, tmp_path: Path) -> None:
    settings = load_mapserver(write_settings(tmp_path, "mapserver", mapserver_settings(recording)))
    assert settings.clock == "world"
    for robot, rig in zip(settings.robots, (robot.rig for robot in recording.robots), strict=True):
        assert (robot.name, robot.initial_pose, robot.initial_pose_sigma) == (rig.name, rig.initial_pose, rig.initial_pose_sigma)


def test_agents_and_map_server_share_a_site(recording: Recording) -> None:
    assert agent_settings(recording, recording.robots[0], "full", SWARM, WORLD).robot.site == mapserver_settings(recording).site


def test_a_calibration_that_is_no_number_is_named_with_file_and_field(tmp_path: Path) -> None:
    shutil.copytree(EXCERPT, tmp_path / "spoilt")
    sensor = tmp_path / "spoilt" / "r3" / "cam0" / "sensor.yaml"
    sensor.write_text(re.sub(r"intrinsics: \[[0-9.]+", "intrinsics: [.nan", sensor.read_text()))
    recording = Recording.open(tmp_path / "spoilt")
    with pytest.raises(ConfigError, match=r"r3/cam0/sensor\.yaml: `intrinsics\[0\]`"):
        check_robots(recording)


def test_a_robot_cannot_take_the_map_servers_name(tmp_path: Path) -> None:
    shutil.copytree(EXCERPT, tmp_path / "spoilt")
    (tmp_path / "spoilt" / "r3").rename(tmp_path / "spoilt" / "mapserver")
    rigs = tmp_path / "spoilt" / "robots.yaml"
    rigs.write_text(rigs.read_text().replace("name: r3", "name: mapserver"))
    with pytest.raises(ConfigError, match="no robot can be named mapserver"):
        check_robots(Recording.open(tmp_path / "spoilt"))


def test_a_robot_too_large_for_an_agent_is_named_with_its_file(tmp_path: Path) -> None:
    shutil.copytree(EXCERPT, tmp_path / "spoilt")
    rigs = tmp_path / "spoilt" / "robots.yaml"
    rigs.write_text(rigs.read_text().replace("wheel_base_m: 0.12", "wheel_base_m: 120.0"))
    recording = Recording.open(tmp_path / "spoilt")
    with pytest.raises(ConfigError, match=r"robots\.yaml: `body\.wheel_base_m`"):
        agent_settings(recording, recording.robots[0], "full", SWARM, WORLD)
