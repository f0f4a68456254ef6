"""`ommatidia calibrate rig --drive`: a simulated robot drives its figure by real processes, and its rig is that of the world."""

from __future__ import annotations

import io
import socket
from collections.abc import Iterator
from pathlib import Path

import pytest

from agent.calibration import read_calibration
from deploy.cli import run
from deploy.launch import Processes
from deploy.settings_files import SITE, agent_settings, write_settings
from deploy.swarm import CAMERA_AGENT
from deploy.told_team import read_team
from protocol import topics
from protocol.bus import Bus
from protocol.geometry import Pose2
from protocol.messages import WorldTruth
from tests.wall_world import start_wall_world

SCENARIO = """
name = "figure"
seed = 3
duration_s = 600.0

[arena]
floor = "paint"

[camera]
width_px = 480
height_px = 360
rate_hz = 5.0

[[boxes]]
centre_m = [0.9, 0.9]
size_m = [0.3, 0.2]
height_m = 0.15
material = "card"

[[robots]]
name = "r1"
start = [-0.5, -0.1, 0.3]
"""
START = Pose2(-0.5, -0.1, 0.3)


def free_endpoint() -> str:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        return f"tcp/127.0.0.1:{taken.getsockname()[1]}"


@pytest.fixture
def world(tmp_path: Path) -> Iterator[Bus]:
    """Start a world, and an agent that nobody leads yet, whose settings are in config/r1.toml."""
    scenario = tmp_path / "figure.toml"
    scenario.write_text(SCENARIO)
    with Processes(tmp_path / "logs") as processes:
        told = tmp_path / "world"
        endpoint = start_wall_world(processes, scenario, told)
        team = read_team(told)
        settings = agent_settings(team, team.robots[0], "full", free_endpoint(), endpoint)
        processes.start("r1", "-m", CAMERA_AGENT, "--config", str(write_settings(tmp_path / "config", "r1", settings)))
        with Bus.open_client(SITE, endpoint) as world:
            yield world


@pytest.mark.slow
@pytest.mark.timeout(200)
def test_a_robot_drives_its_figure_and_tells_its_rig(
    world: Bus, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    truths = world.inbox(topics.WORLD_TRUTH)
    monkeypatch.setattr("sys.stdin", io.StringIO("\n"))
    out = tmp_path / "calibration"
    assert run(["calibrate", "rig", "--config", str(tmp_path / "config" / "r1.toml"), "--drive", "--out", str(out)]) == 0

    assert read_calibration(out / "sensor.yaml").camera_height_m == pytest.approx(0.5, rel=0.01)
    told = dict(line.split(" = ") for line in capsys.readouterr().out.splitlines() if " = " in line)
    assert float(told["  wheel_base_m"]) == pytest.approx(0.12, rel=0.02)
    assert float(told["  wheel_radius_m"]) == pytest.approx(0.03, rel=0.015)
    assert stands_at(truths.take()[-1]) == pytest.approx((1.0, 0.0), abs=0.05)


def stands_at(truth: WorldTruth) -> tuple[float, float]:
    """Return where the robot is as seen from where it began [m]; it has run into nothing."""
    body = truth.bodies[0]
    assert body.collisions == 0
    x_m, y_m, _ = START.inverse() @ Pose2(*body.arena_from_body)
    return x_m, y_m
