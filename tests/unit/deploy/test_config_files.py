"""The commented settings files that are installed: every key is there, and what stands behind a hash is the default."""

from __future__ import annotations

import json
import re
import tomllib
from pathlib import Path

import pytest
from pydantic import BaseModel

from agent.calibration import read_calibration
from agent.config import AgentConfig, BodySettings, DriveSettings, RosArduinoBridgeSettings, V4l2CameraSettings
from agent.config import RobotSettings as AgentRobotSettings
from mapserver.config import FormationSettings, GraphSettings, LossSettings, MapServerConfig, RobotSettings

SETTINGS = Path(__file__).parents[3] / "deploy" / "config"
NONE_IS_SHOWN_BY_EXAMPLE = {"leader", "bounds", "deck_radius_m", "deck_height_m", "pid"}


def uncommented(file: str) -> dict[str, object]:
    """Return a settings file with all that stands behind a hash put in."""
    return tomllib.loads(re.sub(r"^# (?=\w+ = )", "", (SETTINGS / file).read_text(), flags=re.MULTILINE))


@pytest.mark.parametrize(
    ("file", "path", "model"),
    [
        ("mapserver.toml", (), MapServerConfig),
        ("mapserver.toml", ("robots", 0), RobotSettings),
        ("mapserver.toml", ("formation",), FormationSettings),
        ("mapserver.toml", ("graph",), GraphSettings),
        ("mapserver.toml", ("loss",), LossSettings),
        ("agent.toml", (), AgentConfig),
        ("agent.toml", ("robot",), AgentRobotSettings),
        ("agent.toml", ("body",), BodySettings),
        ("agent.toml", ("camera",), V4l2CameraSettings),
        ("agent.toml", ("wheels",), RosArduinoBridgeSettings),
        ("agent.toml", ("drive",), DriveSettings),
    ],
)
def test_every_key_is_explained_with_its_default(file: str, path: tuple[str | int, ...], model: type[BaseModel]) -> None:
    whole = uncommented(file)
    given = tomllib.loads((SETTINGS / file).read_text())
    for step in path:
        whole, given = whole[step], given.get(step, {}) if isinstance(step, str) else given[step]  # type: ignore[index,assignment]
    assert whole.keys() == model.model_fields.keys()
    for key in whole.keys() - given.keys() - NONE_IS_SHOWN_BY_EXAMPLE:
        default = model.model_fields[key].get_default()
        assert whole[key] == json.loads(json.dumps(default, default=str)), key


def test_the_lens_that_is_installed_can_be_used() -> None:
    assert read_calibration(SETTINGS / "sensor.yaml").width_px == 640
