"""Settings files: what is wrong with one is told in one line that names file, field and remedy."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import pytest
from pydantic import Field

from protocol.errors import ConfigError
from protocol.settings import Settings, load_toml


class Robot(Settings):
    name: str
    speed_m_s: Annotated[float, Field(gt=0.0, allow_inf_nan=False)] = 0.3
    start: tuple[float, float] | None = None


class Radio(Settings):
    kind: Literal["radio"]
    channel: int = 1


class Cable(Settings):
    kind: Literal["cable"]
    length_m: float


class Swarm(Settings):
    site: str = "home"
    link: Annotated[Radio | Cable, Field(discriminator="kind")] = Radio(kind="radio")
    robots: tuple[Robot, ...] = ()
    log: Path = Path("log")


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "swarm.toml"


def complaint(file: Path, text: str) -> str:
    file.write_text(text)
    with pytest.raises(ConfigError) as caught:
        load_toml(file, Swarm)
    assert "\n" not in str(caught.value)
    assert str(caught.value).startswith(f"{file}: ")
    return str(caught.value).removeprefix(f"{file}: ")


def test_file_overlays_the_defaults_in_code(file: Path) -> None:
    file.write_text('log = "here"\n[[robots]]\nname = "r1"\nspeed_m_s = 1\nstart = [0.5, -1]\n')
    assert load_toml(file, Swarm) == Swarm(log=Path("here"), robots=(Robot(name="r1", speed_m_s=1.0, start=(0.5, -1.0)),))


def test_unknown_key_is_refused_with_the_nearest_known_one(file: Path) -> None:
    assert complaint(file, '[[robots]]\nname = "r1"\nspeed_ms = 1') == "unknown key `robots[0].speed_ms`; did you mean `speed_m_s`?"


def test_unknown_key_is_named_before_the_key_that_is_missing_for_it(file: Path) -> None:
    assert complaint(file, '[[robots]]\nnaem = "r1"') == "unknown key `robots[0].naem`; did you mean `name`? (1 more)"


def test_unknown_key_without_a_near_one_is_refused_with_all_known_ones(file: Path) -> None:
    assert complaint(file, "zzz = 1") == "unknown key `zzz`; known here: link, log, robots, site"


def test_missing_key_is_named(file: Path) -> None:
    assert complaint(file, "[[robots]]\nspeed_m_s = 1.0") == "`robots[0].name` is missing"


@pytest.mark.parametrize("value", ['"0.3"', "true", "0.0", "nan", "inf", "1979-05-27"])
def test_value_of_wrong_type_or_beyond_its_limits_is_refused_with_its_field(file: Path, value: str) -> None:
    assert complaint(file, f'[[robots]]\nname = "r1"\nspeed_m_s = {value}').startswith("`robots[0].speed_m_s`: ")


def test_number_in_place_of_a_text_is_refused(file: Path) -> None:
    assert complaint(file, "site = 7") == "`site`: Input should be a valid string, not 7"


def test_long_value_is_cut_in_the_complaint(file: Path) -> None:
    assert complaint(file, f"site = [{'1, ' * 1000}]").endswith("...")


def test_what_is_not_toml_is_refused_with_its_line(file: Path) -> None:
    assert "line 2" in complaint(file, 'site = "a"\nrobots = = 3')


def test_file_that_is_not_text_is_refused(file: Path) -> None:
    file.write_bytes(b"site = '\xff'")
    with pytest.raises(ConfigError, match="is not UTF-8 text"):
        load_toml(file, Swarm)


def test_absent_file_is_named(file: Path) -> None:
    with pytest.raises(ConfigError, match=r"swarm\.toml: cannot be read: No such file"):
        load_toml(file, Swarm)


def test_unknown_key_of_one_of_several_tables_is_refused_with_the_nearest_key_of_that_table(file: Path) -> None:
    assert complaint(file, '[link]\nkind = "cable"\nlength = 2.0') == "unknown key `link.length`; did you mean `length_m`? (1 more)"


def test_key_of_another_table_of_a_choice_is_unknown(file: Path) -> None:
    text = '[link]\nkind = "radio"\nlength_m = 2.0'
    assert complaint(file, text) == "unknown key `link.length_m`; known here: channel, kind"


def test_bad_value_of_one_of_several_tables_is_named_as_it_stands_in_the_file(file: Path) -> None:
    assert complaint(file, '[link]\nkind = "radio"\nchannel = "one"').startswith("`link.channel`: ")


def test_choice_that_there_is_not_is_refused_with_those_that_there_are(file: Path) -> None:
    assert complaint(file, '[link]\nkind = "string"') == "`link.kind`: expected one of 'radio', 'cable', not 'string'"
