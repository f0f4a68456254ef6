"""Scenario files: what they may say, and one clear line where they say it wrong."""

from __future__ import annotations

from pathlib import Path

import pytest

from protocol.errors import ConfigError
from sim.scenario import SCENARIOS, CameraTable, load_scenario, scenario_file

ROBOT = '[[robots]]\nname = "r1"\nstart = [0.0, 0.0, 0.0]\n'


def complaint(folder: Path, text: str) -> str:
    """Return what is said of a scenario."""
    file = folder / "bad.toml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(ConfigError) as error:
        load_scenario(file)
    [line] = str(error.value).splitlines()
    assert line.startswith(f"{file}: ")
    return line.removeprefix(f"{file}: ")


@pytest.mark.parametrize("file", sorted(SCENARIOS.glob("*.toml")), ids=lambda file: file.stem)
def test_every_scenario_that_ships_can_be_used(file: Path) -> None:
    assert load_scenario(file).robots


def test_a_scenario_is_found_by_its_name_or_its_file(tmp_path: Path) -> None:
    own = tmp_path / "own.toml"
    own.write_text(ROBOT, encoding="utf-8")
    assert scenario_file("gate") == SCENARIOS / "gate.toml"
    assert scenario_file(str(own)) == own


def test_a_name_that_no_scenario_has_is_answered_with_those_there_are() -> None:
    with pytest.raises(ConfigError, match=r"gatee: no such scenario; .*: empty, gate, passer_by"):
        scenario_file("gatee")


def test_a_robot_and_its_start_are_all_that_is_needed(tmp_path: Path) -> None:
    file = tmp_path / "small.toml"
    file.write_text(ROBOT, encoding="utf-8")
    scenario = load_scenario(file)
    assert (scenario.arena.walls, scenario.arena.floor) == (True, "paint")
    assert scenario.robots[0].rig.body_radius_m == 0.075
    assert scenario.robots[0].told_sigma(0) == (0.0, 0.0, 0.0)


def test_the_default_lens_is_the_recorded_one_scaled_about_the_pictures_corner() -> None:
    assert CameraTable(width_px=1280, height_px=960).lens_px() == (294.394685, 294.394685, 638.347555, 483.477415)
    fx, fy, cx, cy = CameraTable().lens_px()
    assert (fx, fy) == (147.1973425, 147.1973425)
    assert (cx, cy) == pytest.approx(((638.347555 - 0.5) / 2, (483.477415 - 0.5) / 2))


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (f"flor = 'grid'\n{ROBOT}", "unknown key `flor`"),
        (f"[arena]\nflor = 'grid'\n{ROBOT}", "unknown key `arena.flor`; did you mean `floor`?"),
        (f"[arena]\nfloor = 'carpet'\n{ROBOT}", "`arena.floor`"),
        (f"[arena]\nx_min_m = 3.0\n{ROBOT}", "x_min_m must be less than x_max_m"),
        (f"[camera]\nmodel = 'hemispherical'\n{ROBOT}", "sees 176 degrees at most"),
        ("name = 'nobody'\n", "`robots` is missing"),
        (ROBOT + ROBOT, "r1 is there more than once"),
        (ROBOT.replace("0.0, 0.0, 0.0", "9.0, 0.0, 0.0"), "robots[0].start: r1 would start outside the arena"),
        (f"goals_m = [[0.0, 5.0]]\n{ROBOT}", "goals_m[0]: lies outside the arena"),
        (f"{ROBOT}[robots.truth]\nleft_wheel_scale = 7.0\n", "`robots[0].truth.left_wheel_scale`"),
        (f"{ROBOT}[[boxes]]\ncentre_m = [0, 0]\nsize_m = [0.1, -0.1]\nheight_m = 0.1\n", "`boxes[0].size_m[1]`"),
        (f"{ROBOT}[[people]]\nway_m = [[0, 0]]\n", "`people[0].way_m`"),
        (f'{ROBOT}[[faults]]\nrobot = "r9"\nkind = "camera_dark"\nfrom_s = 1\nuntil_s = 2\n', "faults[0].robot: there is no robot r9"),
        (f'{ROBOT}[[faults]]\nrobot = "r1"\nkind = "camera_dark"\nfrom_s = 2\nuntil_s = 1\n', "until_s must be later than from_s"),
    ],
)
def test_what_is_wrong_is_named(tmp_path: Path, text: str, says: str) -> None:
    assert says in complaint(tmp_path, text)
