"""The configuration file: what it takes, and one clear line for what it does not."""

from __future__ import annotations

from pathlib import Path

import pytest

from mapserver.config import MapServerConfig, RobotSettings, load_config, starts_of
from mapserver.mapping.poses.track import Start
from protocol.errors import ConfigError
from protocol.geometry import Pose2

MINIMAL = """
site = "lab"

[[robots]]
name = "r1"
initial_pose = [0, 0.5, 0.1]
"""
TWO = (
    MINIMAL
    + """
[[robots]]
name = "r2"
initial_pose = [-1, 0, 0]
"""
)


def load(folder: Path, text: str) -> MapServerConfig:
    file = folder / "mapserver.toml"
    file.write_text(text)
    return load_config(file)


def test_what_only_the_owner_knows_is_enough(tmp_path: Path) -> None:
    config = load(tmp_path, MINIMAL)
    assert (config.site, config.clock, config.listen) == ("lab", "wall", "tcp/127.0.0.1:0")
    start = config.robots[0].start()
    assert start is not None
    assert start.arena_from_body == (0.0, 0.5, 0.1)
    assert start.sigma == (0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        (MINIMAL + "initial_posse_sigma = [0, 0, 0]", "`robots[0].initial_posse_sigma`; did you mean `initial_pose_sigma`?"),
        ('sight = "lab"\n' + MINIMAL, "`sight`; did you mean `site`?"),
        (MINIMAL + MINIMAL.replace('site = "lab"', ""), "r1 is there more than once"),
        (MINIMAL + "initial_pose_sigma = [0, 0, nan]", "`robots[0].initial_pose_sigma"),
        (MINIMAL + "body_radius_m = -1", "`robots[0].body_radius_m`"),
        (MINIMAL.replace("0.1]", "]"), "`robots[0].initial_pose"),
        ('clock = "sundial"\n' + MINIMAL, "`clock`"),
        ('site = "lab"\nrobots = []', "`robots`"),
        ('listen = "localhost"\n' + MINIMAL, "`listen`"),
        (MINIMAL + '[formation]\nkind = "wedge"\nangel_rad = 1', "`formation.angel_rad`; did you mean `angle_rad`?"),
        (MINIMAL + '[formation]\nkind = "heap"', "`formation.kind`"),
        (MINIMAL + '[formation]\nleader = "r7"', "formation.leader r7 is none of the robots"),
        (MINIMAL + "[formation]\nbounds = [0, 0, 0, 1]", "bounds have to be x_min, y_min, x_max, y_max"),
        (MINIMAL + "[formation]\ncruise_m_s = 0.3", "cruise_m_s has to be at most max_speed_m_s"),
        (TWO + '[formation]\nkind = "line"\ndistance_m = 0.2', "formation puts two robots 0.20 m apart"),
        (TWO + '[formation]\nkind = "free"\noffsets = [[-0.4, 0.0]]', "puts a follower ahead of its leader"),
        (TWO + '[formation]\nkind = "free"', "1 followers, but only 0 free offsets"),
    ],
)
def test_a_wrong_file_is_told_in_one_line_with_file_and_key(tmp_path: Path, text: str, complaint: str) -> None:
    with pytest.raises(ConfigError) as error:
        load(tmp_path, text)
    assert complaint in str(error.value)
    assert "mapserver.toml" in str(error.value)
    assert "\n" not in str(error.value)


def test_without_a_formation_nobody_is_asked_to_move(tmp_path: Path) -> None:
    assert load(tmp_path, MINIMAL).task() is None


def test_a_formation_is_led_by_the_first_robot_unless_another_is_named(tmp_path: Path) -> None:
    text = TWO + '[formation]\nkind = "wedge"\ngoals = [[1, 2]]\nbounds = [-2, -2, 3, 3]'
    task = load(tmp_path, text).task()
    assert task is not None
    assert (task.leader, task.goals, task.shape.kind, task.explores) == ("r1", ((1.0, 2.0),), "wedge", False)
    other = load(tmp_path, text + '\nleader = "r2"').task()
    assert other is not None
    assert other.leader == "r2"


def test_an_exploration_goes_in_a_column(tmp_path: Path) -> None:
    task = load(tmp_path, TWO + '[formation]\nkind = "explore"').task()
    assert task is not None
    assert (task.explores, task.shape.kind) == (True, "column")


def test_a_robot_without_a_start_has_to_find_its_place() -> None:
    robots = [RobotSettings(name="r1", initial_pose=(1.0, 0.0, 0.0)), RobotSettings(name="r2")]
    assert starts_of(robots) == {"r1": Start(Pose2(1.0, 0.0, 0.0)), "r2": None}


def test_where_no_start_is_known_the_first_robot_by_name_makes_the_origin() -> None:
    assert starts_of([RobotSettings(name="r2"), RobotSettings(name="r1")]) == {"r1": Start(Pose2.identity()), "r2": None}
