"""`ommatidia config check`: whether a settings file can be used, before a service is started with it."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Literal

from protocol.errors import ConfigError
from protocol.settings import read_text

Role = Literal["agent", "mapserver", "scenario"]

# Keys that tell what a file is meant to be; the first role that has one of them is it.
_TELLING: Mapping[Role, frozenset[str]] = MappingProxyType(
    {
        "agent": frozenset({"robot", "wheels", "body", "drive"}),
        "scenario": frozenset({"arena", "camera", "boxes", "cylinders", "people", "goals_m", "faults"}),
        "mapserver": frozenset({"robots", "listen", "formation", "graph", "clock"}),
    }
)


def check_config(file: Path, role: Role | None, say: Callable[[str], None]) -> None:
    """Check a file, and those that it names, as its service would; raises ConfigError that names file, key and remedy."""
    meant = role or role_of(file)
    say(f"{file}: can be used; {_CHECKS[meant](file)}")


def role_of(file: Path) -> Role:
    """Return whose settings these are; raises ConfigError where that cannot be told."""
    try:
        document = tomllib.loads(read_text(file))
    except tomllib.TOMLDecodeError as error:
        raise ConfigError(f"{file}: is not TOML: {error}") from None
    for role, tables in _TELLING.items():
        if tables & document.keys():
            return role
    raise ConfigError(f"{file}: has no table of an agent, a map server or a scenario; say which it is to be: --role agent")


def _check_agent(file: Path) -> str:
    from agent.calibration import read_calibration
    from agent.config import load_config

    config = load_config(file)
    lens = read_calibration(config.camera.calibration)
    return f"agent of robot {config.robot.name}, camera of {lens.width_px}x{lens.height_px} pixels"


def _check_mapserver(file: Path) -> str:
    from mapserver.config import load_config

    config = load_config(file)
    return f"map server of {', '.join(robot.name for robot in config.robots)}, listening on {config.listen}"


def _check_scenario(file: Path) -> str:
    from sim.scenario import load_scenario

    scenario = load_scenario(file)
    return f"scenario with {', '.join(robot.name for robot in scenario.robots)}"


_CHECKS: Mapping[Role, Callable[[Path], str]] = MappingProxyType(
    {"agent": _check_agent, "mapserver": _check_mapserver, "scenario": _check_scenario}
)
