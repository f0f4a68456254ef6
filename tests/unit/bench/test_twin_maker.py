"""A recording's simulated twin: what it shares with the recording, what it shows, and what is said where there can be none."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from protocol.errors import ConfigError, RecordingError
from sim.recording import Recording
from tests.bench.frames import EXCERPT
from tests.bench.twin_maker import MARK_FILE, make_twin

FRAMES = 2
LOST = "1412172400200000000.jpg"  # r2's second picture
BANDS = {"r2": np.s_[330:352, 238:268], "r3": np.s_[330:352, 368:400]}  # where r1's first picture shows the dark bands of the others
DARK = 70


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a copy of the excerpt's first frames, on little floor, with a picture lost and a box that is carried away after 0.1 s."""
    folder = tmp_path_factory.mktemp("twins") / "recorded"
    shutil.copytree(EXCERPT, folder)
    for table in folder.glob("*/cam0/data.csv"):
        table.write_text("".join(table.read_text().splitlines(keepends=True)[: 1 + FRAMES]))
    (folder / "r2" / "cam0" / "data" / LOST).unlink()
    world = json.loads((folder / "ground_truth" / "world.json").read_text())
    world["arena_bounds"] = [[-0.8, -0.2], [-0.7, -0.2], [-0.7, -0.1], [-0.8, -0.1]]
    world["obstacles"] = [{**world["obstacles"][0], "footprint": [[-0.4, -0.3], [-0.2, -0.3], [-0.2, -0.1]], "present_until_s": 0.1}]
    (folder / "ground_truth" / "world.json").write_text(json.dumps(world))
    return folder


@pytest.fixture
def spoilt(recorded: Path, tmp_path: Path) -> Path:
    """Return a copy of that recording, to be spoilt."""
    return shutil.copytree(recorded, tmp_path / "recorded")


@pytest.fixture(scope="module")
def twin(recorded: Path) -> Path:
    """Return its twin of seed 1."""
    return twin_of(recorded, recorded.with_name("twin"))


def twin_of(folder: Path, out: Path, seed: int = 1) -> Path:
    make_twin(Recording.open(folder), out, seed, lambda: None)
    return out


def picture(folder: Path, robot: str, frame: int = 0) -> NDArray[np.int_]:
    file = sorted((folder / robot / "cam0" / "data").iterdir())[frame]
    return np.asarray(cv2.imread(str(file)), np.int_)


def test_a_twin_is_a_recording_that_shares_all_but_the_pictures(recorded: Path, twin: Path) -> None:
    assert Recording.open(twin).names == ("r1", "r2", "r3")
    for file in ("robots.yaml", "ground_truth/world.json", "ground_truth/r2.tum", "r3/cam0/sensor.yaml", "r3/wheels0/data.csv"):
        assert (twin / file).read_bytes() == (recorded / file).read_bytes()
    assert json.loads((twin / MARK_FILE).read_text()) == {"twin_of": "recorded", "seed": 1}


def test_a_lost_frame_stays_lost(twin: Path) -> None:
    assert [file.name for file in (twin / "r2" / "cam0" / "data").iterdir()] == ["1412172400000000000.jpg"]


def test_other_robots_are_painted_where_the_recording_shows_them(recorded: Path, twin: Path) -> None:
    before, painted = (picture(folder, "r1") for folder in (recorded, twin))
    for band in BANDS.values():
        assert before[band].min() < DARK
        assert painted[band].min() < DARK


def test_what_is_carried_away_is_gone(twin: Path) -> None:
    assert np.abs(picture(twin, "r1", frame=0) - picture(twin, "r1", frame=1)).max() > 60


def test_a_seed_gives_the_same_pictures_again_and_another_one_others(recorded: Path, twin: Path, tmp_path: Path) -> None:
    first, again, other = (picture(folder, "r3") for folder in (twin, twin_of(recorded, tmp_path), twin_of(recorded, tmp_path / "2", 2)))
    assert (first == again).all()
    assert (first != other).any()


def test_a_recording_without_truth_has_no_twin(spoilt: Path, tmp_path: Path) -> None:
    shutil.rmtree(spoilt / "ground_truth")
    with pytest.raises(RecordingError, match="has no ground_truth/"):
        twin_of(spoilt, tmp_path / "twin")


def test_a_frame_beyond_the_true_path_is_named(spoilt: Path, tmp_path: Path) -> None:
    path = spoilt / "ground_truth" / "r3.tum"
    path.write_text("".join(path.read_text().splitlines(keepends=True)[:2]))
    with pytest.raises(RecordingError, match=r"ground_truth/r3\.tum: has no pose for the frame at 1412172400200000000 ns"):
        twin_of(spoilt, tmp_path / "twin")


def test_nothing_but_a_twin_is_ever_replaced(recorded: Path, tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="is the recording itself"):
        twin_of(recorded, recorded)
    precious = tmp_path / "precious"
    shutil.copytree(EXCERPT / "r1", precious)
    with pytest.raises(ConfigError, match=r"holds no twin \(twin\.json is missing\)"):
        twin_of(recorded, precious)
    assert (precious / "wheels0" / "data.csv").is_file()


def test_where_nothing_can_be_written_that_is_said(recorded: Path, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(ConfigError, match="cannot be written"):
        twin_of(recorded, tmp_path / "file" / "twin")
