"""The ground truth of a recording, read, and what is said where it cannot be."""

import json
import shutil
from pathlib import Path
from typing import Any

import pytest

from deploy.evaluation.truth import read_truth
from protocol.errors import RecordingError
from tests.unit.deploy.worlds import START_NS, write_recording


def change_world(recording: Path, **changes: Any) -> None:
    file = recording / "ground_truth" / "world.json"
    file.write_text(json.dumps(json.loads(file.read_text(encoding="utf-8")) | changes), encoding="utf-8")


def test_a_recording_tells_paths_obstacles_and_bounds(tmp_path: Path) -> None:
    truth = read_truth(write_recording(tmp_path / "room"))
    assert truth.name == "room"
    assert list(truth.trajectories) == ["r1", "r2"]
    assert truth.arena_bounds.area == pytest.approx(12.0)
    assert [item.footprint.area for item in truth.obstacles] == pytest.approx([0.04] * 3)
    assert truth.body_radius_m == {"r1": 0.075, "r2": 0.075}


def test_present_until_counts_from_the_first_stamp(tmp_path: Path) -> None:
    truth = read_truth(write_recording(tmp_path / "room"))
    assert truth.obstacles[2].present_until_ns == START_NS + 800_000_000
    assert [truth.stands_at_end(item) for item in truth.obstacles] == [True, True, False]


def test_a_recording_without_truth_is_told_in_one_line(tmp_path: Path) -> None:
    recording = write_recording(tmp_path / "room")
    shutil.rmtree(recording / "ground_truth")
    with pytest.raises(RecordingError, match="room: has no ground_truth/") as raised:
        read_truth(recording)
    assert "\n" not in str(raised.value)


def test_a_robot_without_a_true_path_is_named(tmp_path: Path) -> None:
    recording = write_recording(tmp_path / "room")
    (recording / "ground_truth" / "r2.tum").unlink()
    with pytest.raises(RecordingError, match=r"r2\.tum: cannot be read"):
        read_truth(recording)


def test_an_empty_true_path_is_named(tmp_path: Path) -> None:
    recording = write_recording(tmp_path / "room")
    (recording / "ground_truth" / "r2.tum").write_text("# nothing\n", encoding="utf-8")
    with pytest.raises(RecordingError, match=r"r2\.tum: holds no pose"):
        read_truth(recording)


SQUARE = [[0, 0], [1, 0], [1, 1], [0, 1]]
BOWTIE = [[0, 0], [1, 1], [1, 0], [0, 1]]


@pytest.mark.parametrize(
    ("changes", "what"),
    [
        ({"arena_bounds": None}, r"world\.json: arena_bounds: "),
        ({"frame": "map"}, r"world\.json: frame: "),
        ({"obstacles": [{"id": 0, "kind": "box", "height": -1, "footprint": SQUARE}]}, r"world\.json: obstacles\.0\.height: "),
        ({"obstacles": [{"id": 0, "kind": "box", "height": 1, "footprint": SQUARE[:2]}]}, r"world\.json: obstacles\.0\.footprint: "),
        ({"obstacles": [{"id": 0, "kind": "box", "height": 1, "footprint": [[0, "a"]] * 3}]}, r"obstacles\.0\.footprint\.0\.1: "),
        ({"obstacles": [{"id": 7, "kind": "box", "height": 1, "footprint": BOWTIE}]}, r"obstacle 7: footprint: is no simple polygon"),
        ({"obstacles": [{"id": 7, "kind": "box", "height": 1, "footprint": SQUARE}] * 2}, r"obstacles: id: the same id stands twice"),
    ],
)
def test_a_field_of_the_world_that_cannot_be_used_is_named(tmp_path: Path, changes: dict[str, Any], what: str) -> None:
    recording = write_recording(tmp_path / "room")
    change_world(recording, **changes)
    with pytest.raises(RecordingError, match=what):
        read_truth(recording)


def test_a_world_that_is_no_json_is_told(tmp_path: Path) -> None:
    recording = write_recording(tmp_path / "room")
    (recording / "ground_truth" / "world.json").write_text('{"obstacles": [', encoding="utf-8")
    with pytest.raises(RecordingError, match=r"world\.json: is not JSON"):
        read_truth(recording)


def test_robots_that_are_no_yaml_are_told_in_one_line(tmp_path: Path) -> None:
    recording = write_recording(tmp_path / "room")
    (recording / "robots.yaml").write_text("robots: [\n", encoding="utf-8")
    with pytest.raises(RecordingError, match=r"robots\.yaml: is not YAML") as raised:
        read_truth(recording)
    assert "\n" not in str(raised.value)
