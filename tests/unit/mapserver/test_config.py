"""The configuration file: what it takes, and one clear line for what it does not."""

from __future__ import annotations

from pathlib import Path

import pytest

from mapserver.config import MapServerConfig, load_config
from protocol.errors import ConfigError

MINIMAL = """
site = "lab"

[[robots]]
name = "r1"
initial_pose = [0, 0.5, 0.1]
"""


def load(folder: Path, text: str) -> MapServerConfig:
    file = folder / "mapserver.toml"
    file.write_text(text)
    return load_config(file)


def test_what_only_the_owner_knows_is_enough(tmp_path: Path) -> None:
    config = load(tmp_path, MINIMAL)
    assert (config.site, config.clock, config.listen) == ("lab", "wall", "tcp/127.0.0.1:0")
    start = config.robots[0].start()
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
    ],
)
def test_a_wrong_file_is_told_in_one_line_with_file_and_key(tmp_path: Path, text: str, complaint: str) -> None:
    with pytest.raises(ConfigError) as error:
        load(tmp_path, text)
    assert complaint in str(error.value)
    assert "mapserver.toml" in str(error.value)
    assert "\n" not in str(error.value)
