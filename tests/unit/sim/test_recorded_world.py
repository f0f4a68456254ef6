"""A recording's truth as a scene, its robots' looks and its cameras' views; and what is said of files that cannot be used."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from agent.vision.floor_view import REACH_IN_HEIGHTS
from protocol.errors import RecordingError
from sim.recorded_world import read_bodies, read_ceiling_view, read_departures, read_scene, read_view
from sim.world.floor_picture import MARGIN_M

SENSOR = """\
{mount}:
  cols: 4
  rows: 4
  data: [0, -1, 0, 0, -1, 0, 0, 0, 0, 0, -1, {height_m}, 0, 0, 0, 1]
resolution: [1280, 960]
camera_model: {model}
intrinsics: [290.0, 291.0, 640.0, 480.0]
distortion_coefficients: [0, 0, 0, 0]
"""
WORLD = {
    "floor_variant": "grid",
    "arena_bounds": [[-2, -1.5], [2, -1.5], [2, 1.5], [-2, 1.5]],
    "obstacles": [
        {"id": 0, "kind": "box", "material": "card", "height": 0.14, "footprint": [[0, 0], [1, 0], [1, 1]]},
        {"id": 1, "kind": "cylinder", "material": "velvet", "height": 0.2, "footprint": [[0, 0], [1, 0], [1, 1]], "present_until_s": 3.5},
    ],
}


@pytest.fixture
def recorded(tiny: Path) -> Path:
    (tiny / "ground_truth").mkdir()
    (tiny / "ground_truth" / "world.json").write_text(json.dumps(WORLD, indent=1))
    fisheye = SENSOR.format(mount="T_BS", height_m=0.5, model="kannala_brandt") + "fov_deg: 185\n"
    (tiny / "r1" / "cam0" / "sensor.yaml").write_text(fisheye)
    (tiny / "ceiling" / "cam0").mkdir(parents=True)
    (tiny / "ceiling" / "cam0" / "sensor.yaml").write_text(SENSOR.format(mount="T_WS", height_m=3.2, model="pinhole"))
    return tiny


def test_a_scene_holds_the_recorded_things(recorded: Path) -> None:
    scene = read_scene(recorded)
    assert scene.floor == "grid"
    assert [(thing.kind, thing.height_m, thing.material) for thing in scene.things] == [("box", 0.14, "card"), ("cylinder", 0.2, "speckle")]


def test_floor_goes_on_past_the_bounds_farther_than_robots_judge_it(recorded: Path) -> None:
    scene = read_scene(recorded)
    farthest_m = REACH_IN_HEIGHTS * read_bodies(recorded)["r1"].camera_height_m
    assert scene.x_max_m + MARGIN_M - 2.0 > farthest_m
    assert scene.y_min_m - MARGIN_M + 1.5 < -farthest_m


def test_what_is_carried_away_is_told_with_its_time(recorded: Path) -> None:
    assert read_departures(recorded) == {"cylinder-1": 3.5}


def test_bodies_and_views_are_as_recorded(recorded: Path) -> None:
    assert read_bodies(recorded)["r2"].deck_radius_m == 0.071
    view = read_view(recorded, "r1")
    assert view.eye_m.tolist() == [0.0, 0.0, 0.5]
    assert view.pixels(np.zeros(3)) + view.origin_px == pytest.approx([640.0, 480.0])
    assert read_ceiling_view(recorded).eye_m.tolist() == [0.0, 0.0, 3.2]


def test_a_file_that_cannot_be_used_is_named_with_its_field(recorded: Path) -> None:
    file = recorded / "ground_truth" / "world.json"
    file.write_text(file.read_text().replace("0.14", "-0.14"))
    with pytest.raises(RecordingError, match=r"ground_truth/world\.json, obstacles\.0\.height: "):
        read_scene(recorded)
    file.write_text("{")
    with pytest.raises(RecordingError, match=r"ground_truth/world\.json: is not YAML"):
        read_scene(recorded)
