"""`ommatidia config check`: a file that can be used is told what it makes, one that cannot what is wrong with it, and where."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from deploy.cli import run
from deploy.config_command import check_config, role_of
from protocol.errors import ConfigError
from sim.scenario import SCENARIOS

SETTINGS = Path(__file__).parents[3] / "deploy" / "config"


def test_settings_of_every_role_are_recognised_and_found_usable(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for file, said in [
        (SETTINGS / "agent.toml", "agent of robot r1"),
        (SETTINGS / "mapserver.toml", "map server of r1, r2"),
        (SCENARIOS / "gate.toml", "scenario with r1"),
    ]:
        assert run(["config", "check", str(file)]) == 0
        assert said in capsys.readouterr().out


def test_an_unknown_key_is_refused_with_the_nearest_known_one(tmp_path: Path) -> None:
    file = tmp_path / "mapserver.toml"
    file.write_text('[[robots]]\nname = "r1"\n[formation]\ndistence_m = 0.5\n')
    with pytest.raises(ConfigError, match=r"mapserver.toml: unknown key `formation.distence_m`; did you mean `distance_m`\?"):
        check_config(file, None, print)


def test_a_missing_calibration_is_named(tmp_path: Path) -> None:
    shutil.copy(SETTINGS / "agent.toml", tmp_path)
    with pytest.raises(ConfigError, match=r"sensor\.yaml: cannot be read"):
        check_config(tmp_path / "agent.toml", None, print)


def test_a_file_of_no_known_role_asks_for_it(tmp_path: Path) -> None:
    file = tmp_path / "odd.toml"
    file.write_text("colour = 'red'\n")
    with pytest.raises(ConfigError, match="say which it is to be: --role agent"):
        role_of(file)


def test_text_that_is_no_toml_is_told_with_its_place(tmp_path: Path) -> None:
    file = tmp_path / "broken.toml"
    file.write_text("[robot\n")
    with pytest.raises(ConfigError, match=r"broken.toml: is not TOML: .*line 1"):
        role_of(file)
