"""What a run has left, read, and what is said where it cannot be."""

import json
import shutil
from pathlib import Path

import pytest
import shapely

from deploy.evaluation.run_folder import read_run_folder
from protocol.errors import RecordingError
from tests.unit.deploy.worlds import perfect_run


def test_a_run_tells_paths_objects_and_grid(tmp_path: Path) -> None:
    run = read_run_folder(perfect_run(tmp_path)[0])
    assert list(run.live) == list(run.smoothed) == ["r1", "r2"]
    assert [(item.id, item.kind, item.height_m) for item in run.objects] == [(100, "obstacle", 0.15), (101, "obstacle", 0.15)]
    assert run.method == "full"
    assert run.grid is not None
    assert run.grid.pixels.shape == (300, 400)
    assert (run.grid.cell_m, run.grid.origin_m) == (0.01, (-2.0, -1.5))


def test_what_is_not_needed_for_a_score_may_be_missing(tmp_path: Path) -> None:
    folder = perfect_run(tmp_path)[0]
    shutil.rmtree(folder / "trajectories" / "smoothed")
    for name in ("run.json", "map.yaml", "map.pgm"):
        (folder / name).unlink()
    run = read_run_folder(folder)
    assert (run.smoothed, run.grid, run.method) == ({}, None, None)


def test_an_outline_that_crosses_itself_keeps_its_area(tmp_path: Path) -> None:
    folder = perfect_run(tmp_path)[0]
    set_ring(folder, [[0, 0], [1, 1], [1, 0], [0, 1], [0, 0]])
    footprint = read_run_folder(folder).objects[0].footprint
    assert footprint.area == pytest.approx(0.5)
    assert shapely.is_valid(footprint)


def set_ring(folder: Path, ring: object) -> None:
    file = folder / "map.geojson"
    content = json.loads(file.read_text(encoding="utf-8"))
    content["features"][0]["geometry"]["coordinates"] = [ring]
    file.write_text(json.dumps(content), encoding="utf-8")


def test_an_outline_that_is_no_ring_is_named(tmp_path: Path) -> None:
    folder = perfect_run(tmp_path)[0]
    set_ring(folder, [[0, 0], [1, 1]])
    with pytest.raises(RecordingError, match=r"map\.geojson: features\.0\.geometry\.coordinates\.0: "):
        read_run_folder(folder)


def test_a_doubled_object_id_is_told(tmp_path: Path) -> None:
    folder = perfect_run(tmp_path)[0]
    text = (folder / "map.geojson").read_text(encoding="utf-8")
    (folder / "map.geojson").write_text(text.replace('"id": 101', '"id": 100'), encoding="utf-8")
    with pytest.raises(RecordingError, match=r"map\.geojson: features: properties: id"):
        read_run_folder(folder)


@pytest.mark.parametrize(
    ("missing", "what"),
    [
        (".", "is no folder of a run"),
        ("trajectories", r"holds no <robot>\.tum"),
        ("map.geojson", r"map\.geojson: cannot be read"),
        ("map.pgm", r"map\.yaml: image: .*map\.pgm is missing or no picture"),
    ],
)
def test_what_a_score_needs_is_named_where_it_is_missing(tmp_path: Path, missing: str, what: str) -> None:
    folder = perfect_run(tmp_path)[0]
    target = folder / missing
    shutil.rmtree(target) if target.is_dir() else target.unlink()
    with pytest.raises(RecordingError, match=what):
        read_run_folder(folder)
