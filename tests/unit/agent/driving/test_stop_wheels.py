"""The program that stops the wheels when nothing else of a robot runs any more."""

from __future__ import annotations

from pathlib import Path

import pytest

from agent.driving.stop_wheels import TIMES, main
from tests.unit.agent.drivers.port import Port

CONFIG = """\
[robot]
name = "r1"
endpoint = "tcp/127.0.0.1:7447"
[camera]
endpoint = "tcp/127.0.0.1:7448"
calibration = "sensor.yaml"
[wheels]
driver = "{driver}"
port = "{port}"
"""


@pytest.mark.parametrize(("driver", "stop"), [("ros_arduino_bridge", b"m 0 0\r"), ("create2", b"\x91\0\0\0\0")])
def test_stop_is_said_more_than_once_and_nothing_else(tmp_path: Path, driver: str, stop: bytes) -> None:
    port = Port(tmp_path)
    port.plug_in()
    (tmp_path / "r1.toml").write_text(CONFIG.format(driver=driver, port=port.path))
    assert main(["--config", str(tmp_path / "r1.toml")]) == 0
    assert port.heard(at_least=TIMES * len(stop)) == TIMES * stop
    port.pull()


def test_port_that_is_gone_is_no_failure(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "r1.toml").write_text(CONFIG.format(driver="create2", port=tmp_path / "wheels"))
    assert main(["--config", str(tmp_path / "r1.toml")]) == 0
    assert capsys.readouterr().err == f"wheels not stopped: {tmp_path / 'wheels'} is not there\n"


def test_configuration_that_cannot_be_read_takes_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--config", str(tmp_path / "r1.toml")]) == 2
    assert capsys.readouterr().err.count("\n") == 1
