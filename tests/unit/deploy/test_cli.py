"""The command line: help with examples, exit codes, and one clear line for whatever is wrong."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from deploy.cli import run

COMMANDS = ("replay", "evaluate", "demo", "agent", "mapserver", "doctor", "stop", "release", "calibrate")
CALIBRATIONS = ("calibrate lens", "calibrate board", "calibrate rig")

Fails = Callable[..., str]


@pytest.fixture
def fails(capsys: pytest.CaptureFixture[str]) -> Fails:
    """Return a function that runs a command line that must fail with exit code 2, and returns the one line it says."""

    def complaint(*arguments: str) -> str:
        assert run(arguments) == 2
        output = capsys.readouterr()
        assert output.out == ""
        assert output.err.startswith("ommatidia: ")
        assert output.err.count("\n") == 1
        return output.err

    return complaint


@pytest.mark.parametrize("command", COMMANDS + CALIBRATIONS)
def test_help_of_every_command_shows_an_example(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run([*command.split(), "--help"]) == 0
    assert f"ommatidia {command}" in capsys.readouterr().out.partition("Examples:")[2]


@pytest.mark.parametrize("command", CALIBRATIONS)
def test_help_says_that_lengths_are_in_metres(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run([*command.split(), "--help"]) == 0
    assert "metres" in capsys.readouterr().out.lower()


@pytest.mark.parametrize("distance", ["-1", "nan", "inf"])
def test_a_distance_that_no_tape_has_is_refused(distance: str, fails: Fails) -> None:
    assert "--distance" in fails("calibrate", "rig", "--config", "agent.toml", "--distance", distance)


@pytest.mark.parametrize("arguments", [[], ["--help"]])
def test_help_lists_all_commands(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert run(arguments) == 0
    listed = capsys.readouterr().out
    assert all(command in listed for command in COMMANDS)


def test_version_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["--version"]) == 0
    assert capsys.readouterr().out.startswith("ommatidia ")


def test_an_unknown_command_is_named(fails: Fails) -> None:
    assert "'fly'" in fails("fly")


def test_an_unknown_option_is_named(fails: Fails, tmp_path: Path) -> None:
    assert "--speed" in fails("replay", str(tmp_path), "--speed", "2")


def test_a_missing_argument_is_named(fails: Fails) -> None:
    assert "RECORDING" in fails("replay")


@pytest.mark.parametrize("rate", ["fast", "0", "-1", "nan", "inf"])
def test_a_rate_that_would_never_play_is_refused(rate: str, fails: Fails, tmp_path: Path) -> None:
    assert f"{rate!r} is neither 'max' nor a number above 0" in fails("replay", str(tmp_path), "--rate", rate)


@pytest.mark.parametrize("command", ["stop", "release"])
@pytest.mark.parametrize("endpoint", ["foo", "192.168.1.20:7447", "tcp/192.168.1.20", "udp/192.168.1.20:7447"])
def test_an_endpoint_of_another_form_is_refused(command: str, endpoint: str, fails: Fails) -> None:
    assert f"{endpoint!r} is no endpoint: say tcp/HOST:PORT" in fails(command, "--endpoint", endpoint)


def test_an_unknown_method_is_refused(fails: Fails, tmp_path: Path) -> None:
    assert "'best' is not one of 'full', 'paper'" in fails("replay", str(tmp_path), "--method", "best")


def test_a_recording_that_is_not_there_is_named(fails: Fails, tmp_path: Path) -> None:
    assert f"{tmp_path / 'nowhere'}: no such folder" in fails("replay", str(tmp_path / "nowhere"))


def test_a_run_that_is_not_there_is_named(fails: Fails, tmp_path: Path) -> None:
    excerpt = Path(__file__).parents[2] / "data" / "excerpt"
    assert f"{tmp_path / 'nowhere'}" in fails("evaluate", str(tmp_path / "nowhere"), "--truth", str(excerpt))


def test_a_recording_without_truth_cannot_judge_a_run(fails: Fails, tmp_path: Path) -> None:
    assert "ground_truth" in fails("evaluate", str(tmp_path), "--truth", str(tmp_path))


@pytest.mark.parametrize("service", ["agent", "mapserver"])
def test_a_settings_file_that_is_not_there_is_named(service: str, tmp_path: Path) -> None:
    assert f"{tmp_path / 'no.toml'}: cannot be read" in complaint_of_service(service, tmp_path / "no.toml")


@pytest.mark.parametrize("service", ["agent", "mapserver"])
def test_an_unknown_key_of_a_settings_file_is_named(service: str, tmp_path: Path) -> None:
    (tmp_path / "settings.toml").write_text("wings = 2\n")
    assert f"{tmp_path / 'settings.toml'}: unknown key `wings`" in complaint_of_service(service, tmp_path / "settings.toml")


def complaint_of_service(service: str, settings: Path) -> str:
    """Return the one line that a service, which must fail with exit code 2, says in a process of its own."""
    command = [sys.executable, "-m", "deploy", service, "--config", str(settings)]
    result = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert (result.returncode, result.stdout, result.stderr.count("\n")) == (2, "", 1)
    return result.stderr


def test_a_folder_that_is_in_use_is_refused(fails: Fails, tmp_path: Path) -> None:
    excerpt = Path(__file__).parents[2] / "data" / "excerpt"
    (tmp_path / "thesis.tex").touch()
    assert "is not empty and holds no run" in fails("replay", str(excerpt), "--out", str(tmp_path))
