"""The figure that a robot drives for its rig, and what is taken of how it gets on."""

from __future__ import annotations

import io
from pathlib import Path

import pytest
from rich.console import Console

from agent.config import AgentConfig, load_config
from deploy.calibration.rig_command import read_tape
from deploy.calibration.rig_drive import LEGS, SETTLE_S, STUCK_S, FigureDrive, figure, figure_settings
from deploy.cli import run
from protocol.bus import Bus
from protocol.messages import FormationState, Phase
from tests.serial_robot import write_serial_robot

AHEAD, BACK = (1.0, 0.0), (0.0, 0.0)


@pytest.fixture
def config(tmp_path: Path) -> AgentConfig:
    return load_config(write_serial_robot(tmp_path, "create2", Path("/dev/null"), "[body]", "body_radius_m = 0.17"))


def state(goal: tuple[float, float] | None, phase: Phase = "moving", reason: str = "") -> FormationState:
    return FormationState(epoch=1, seq=0, stamp_ns=0, phase=phase, reason=reason, leader="r1", goal=goal, slots=())


def test_the_figure_goes_ahead_and_back_and_ends_ahead_within_the_floor_that_is_asked_for(config: AgentConfig) -> None:
    settings = figure_settings(config)
    assert settings.formation.goals == (AHEAD, BACK, AHEAD, BACK, AHEAD)
    assert settings.formation.bounds == (-0.67, -0.67, 1.67, 0.67)
    assert "1.7 m ahead, 0.7 m behind it" in " ".join(figure(config))
    assert (settings.listen, settings.site) == (config.robot.endpoint, config.robot.site)


def test_a_slow_robot_is_asked_for_no_more_than_it_may(config: AgentConfig) -> None:
    slow = config.model_copy(update={"drive": config.drive.model_copy(update={"max_speed_m_s": 0.1})})
    formation = figure_settings(slow).formation
    assert formation.cruise_m_s < formation.max_speed_m_s <= 0.1


def test_each_goal_that_is_left_behind_is_a_leg() -> None:
    drive = FigureDrive()
    drive.note([state(None, "waiting", "waiting for r1"), state(AHEAD), state(AHEAD)], 0.0, 0.0)
    assert (drive.legs, drive.doing) == (0, "moving")
    drive.note([state(BACK, "blocked", "something stands in the way")], 1.0, 5.0)
    assert (drive.legs, drive.doing) == (1, "blocked: something stands in the way")


def test_it_is_over_once_the_robot_has_had_time_to_come_to_rest() -> None:
    drive, seen = FigureDrive(), []
    for states, now_s in (([state(AHEAD)], 0.0), ([state(None, "arrived")], 10.0), ([], 10.1 + SETTLE_S)):
        drive.note(states, 1.0, now_s)
        seen.append((drive.legs, drive.is_over))
    assert seen == [(0, False), (LEGS, False), (LEGS, True)]


def test_a_robot_that_goes_no_farther_is_stuck() -> None:
    drive = FigureDrive()
    for second in range(30):
        drive.note([], 0.1 * min(second, 5), float(second))
    assert drive.stuck_s == 24.0
    assert drive.stuck_s > STUCK_S


def test_a_map_server_that_runs_already_is_told_before_anything_moves(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = write_serial_robot(tmp_path, "create2", Path("/dev/null"))
    (tmp_path / "sensor.yaml").write_text((Path(__file__).parents[3] / "data/excerpt/r1/cam0/sensor.yaml").read_text())
    with Bus.open_router("home") as server:
        file.write_text(file.read_text().replace("tcp/127.0.0.1:1", server.endpoint))
        assert run(["calibrate", "rig", "--config", str(file), "--drive", "--out", str(tmp_path / "out")]) == 2
    assert "a map server runs at" in capsys.readouterr().err


def test_nobody_drives_where_nobody_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    file = write_serial_robot(tmp_path, "create2", Path("/dev/null"))
    (tmp_path / "sensor.yaml").write_text((Path(__file__).parents[3] / "data/excerpt/r1/cam0/sensor.yaml").read_text())
    monkeypatch.setattr("sys.stdin", io.StringIO())
    assert run(["calibrate", "rig", "--config", str(file), "--drive", "--out", str(tmp_path / "out")]) == 2
    assert "press Enter where it asks" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("said", "distance_m"), [("1.013\n", 1.013), ("nan\n-1\n0.1\ninf\na metre\n0.987\n", 0.987), ("\n", None), ("nan\n", None)]
)
def test_what_the_tape_says_is_asked_for_until_it_can_be_so(said: str, distance_m: float | None, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.stdin", io.StringIO(said))
    assert read_tape(Console()) == distance_m


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["--recording", "DIR"], "--drive: moves a robot that runs"),
        (["--config", "FILE", "--distance", "1.0"], "--distance: leave it out with --drive"),
    ],
)
def test_what_does_not_go_with_a_drive_is_refused(arguments: list[str], complaint: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["calibrate", "rig", "--drive", *arguments]) == 2
    assert complaint in capsys.readouterr().err
