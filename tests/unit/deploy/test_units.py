"""The systemd units: little that a broken service could reach, and what keeps the wheels still."""

from __future__ import annotations

import configparser
import re
import shutil
import subprocess
from pathlib import Path

import pytest

UNITS = sorted((Path(__file__).parents[3] / "deploy" / "systemd").glob("*.service"))
MOST_EXPOSED = 2.5

needs_systemd = pytest.mark.skipif(shutil.which("systemd-analyze") is None, reason="systemd-analyze is not installed")


@needs_systemd
@pytest.mark.parametrize("unit", UNITS, ids=lambda unit: unit.stem)
def test_a_service_is_little_exposed(unit: Path) -> None:
    told = subprocess.run(
        ["systemd-analyze", "security", "--offline=yes", "--no-pager", str(unit)], capture_output=True, text=True, check=True
    ).stdout
    exposure = re.search(r"Overall exposure level for \S+: ([\d.]+)", told)
    assert exposure is not None
    assert float(exposure[1]) <= MOST_EXPOSED


@pytest.mark.parametrize("unit", UNITS, ids=lambda unit: unit.stem)
def test_a_service_is_ready_when_it_says_so_is_watched_and_comes_back(unit: Path) -> None:
    service = sections(unit)["Service"]
    assert service["Type"] == "notify"
    assert service["Restart"] == "always"
    assert float(service["WatchdogSec"]) > 0
    assert service["User"] == "ommatidia"


def test_the_wheels_are_stopped_by_a_program_of_its_own_whatever_ended_the_agent() -> None:
    (unit,) = (unit for unit in UNITS if unit.stem == "ommatidia-agent")
    assert "-m agent.driving.stop_wheels" in sections(unit)["Service"]["ExecStopPost"]


def test_what_the_wheel_guard_keeps_outlives_the_agent() -> None:
    (unit,) = (unit for unit in UNITS if unit.stem == "ommatidia-agent")
    service = sections(unit)["Service"]
    assert service["RuntimeDirectory"]
    assert service["RuntimeDirectoryPreserve"] == "yes"


def sections(unit: Path) -> configparser.ConfigParser:
    """Return a unit's sections; of keys that are given more than once the last."""
    parser = configparser.ConfigParser(strict=False, interpolation=None)
    parser.optionxform = str  # type: ignore[assignment,method-assign]
    parser.read(unit)
    return parser
