"""A whole evaluation: scores, tables, evaluation.json and figures."""

import io
import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from rich.console import Console

from deploy.evaluation.document import document
from deploy.evaluation.evaluate import evaluate
from deploy.evaluation.own_frame import moved
from deploy.evaluation.report import write_evaluation
from deploy.evaluation.truth import read_truth
from deploy.evaluation.tum import Trajectory
from protocol.errors import RecordingError
from protocol.geometry import Pose2
from tests.unit.deploy.worlds import STEP_NS, VIEWS, perfect_run, write_perfect_run, write_tum


def report(run: Path, recording: Path) -> str:
    """Write the evaluation of a run and return what a person reads."""
    screen = io.StringIO()
    write_evaluation(evaluate(run, recording), Console(file=screen, width=120))
    return screen.getvalue()


def test_a_perfect_run_has_no_error(tmp_path: Path) -> None:
    evaluation = evaluate(*perfect_run(tmp_path))
    assert evaluation.live.mean.distance_m.max == pytest.approx(0.0, abs=1e-9)
    assert evaluation.smoothed is not None
    assert evaluation.live.mean.matched == evaluation.live.mean.expected == 18
    assert (evaluation.map.recall, evaluation.map.precision) == (1.0, 1.0)
    assert evaluation.map.iou.worst == pytest.approx(1.0)
    assert evaluation.distances is not None
    assert evaluation.distances.x_max_m == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(("name", "not_asked"), [("static_grid_a", {7: "far"}), ("dynamic_a", {}), ("rough_a", {0: "carried away"})])
def test_a_perfect_run_on_a_big_recording_has_no_error(shared: Path, tmp_path: Path, name: str, not_asked: dict[int, str]) -> None:
    recording = shared / "recordings" / name
    evaluation = evaluate(write_perfect_run(tmp_path / "run", read_truth(recording)), recording)
    assert evaluation.live.mean.distance_m.max == pytest.approx(0.0, abs=1e-9)
    assert evaluation.live.mean.matched == evaluation.live.mean.expected
    assert (evaluation.map.recall, evaluation.map.precision) == (1.0, 1.0)
    assert evaluation.map.iou.worst == pytest.approx(1.0)
    assert evaluation.map.centre_error_m.worst == pytest.approx(0.0, abs=1e-6)
    assert {item.obstacle.id: item.status for item in evaluation.map.obstacles if item.status != "asked"} == not_asked


def test_a_run_on_another_recording_is_refused(tmp_path: Path) -> None:
    run, recording = perfect_run(tmp_path)
    for robot, path in read_truth(recording).trajectories.items():
        write_tum(run / "trajectories" / f"{robot}.tum", Trajectory(path.stamps_ns + STEP_NS // 2, path.poses))
    with pytest.raises(RecordingError, match="this is a run on another recording"):
        evaluate(run, recording)


def test_a_robot_without_a_path_is_null_in_the_document_and_leaves_no_mean(tmp_path: Path) -> None:
    run, recording = perfect_run(tmp_path)
    (run / "trajectories" / "r2.tum").unlink()
    paths = json.loads(json.dumps(document(evaluate(run, recording)), allow_nan=False))["paths"]["live"]
    assert paths["robots"]["r2"]["distance_mean_cm"] is None
    assert paths["robots"]["r2"]["poses_expected"] == 9
    assert paths["robots"]["r1"]["distance_mean_cm"] == 0.0
    assert paths["mean"]["distance_mean_cm"] is None


def test_tables_stand_beside_the_papers_own_figures(tmp_path: Path) -> None:
    screen = report(*perfect_run(tmp_path))
    for text in ("5.65", "4.50", "7.32", "8.51", "7.11", "19.60", "11.00", "10.00", "2.23", "1.49", "ommatidia, full", "[cm]", "[deg]"):
        assert text in screen
    assert "carried away" in screen


def test_the_document_has_the_keys_that_it_promises(tmp_path: Path) -> None:
    run, recording = perfect_run(tmp_path)
    report(run, recording)
    content = json.loads((run / "evaluation.json").read_text(encoding="utf-8"))
    assert list(content) == ["version", "label", "run", "recording", "frame", "paths", "distances", "formation", "rigs", "map"]
    assert content["formation"] is None
    assert content["paths"]["live"]["mean"]["distance_mean_cm"] == 0.0
    assert content["distances"]["pairs"] == 1
    assert (content["map"]["asked"], content["map"]["found"], content["map"]["invented"]) == (2, 2, 0)
    assert content["map"]["obstacles"][2]["status"] == "carried away"


def test_every_figure_of_the_paper_is_drawn(tmp_path: Path) -> None:
    run, recording = perfect_run(tmp_path, VIEWS)
    screen = report(run, recording)
    views = [
        f"fig{name}_{robot}" for name in ("04_labels", "05_connected", "06_vectors", "08_corrected", "09_hulls") for robot in ("r1", "r2")
    ]
    others = ["fig15_local_map_r1", "fig16_local_map_r2", "fig18_global_map", "fig21_paths_r1", "fig21_paths_r2", "fig22_errors"]
    assert sorted(file.stem for file in (run / "figures").iterdir()) == sorted(views + others)
    for file in (run / "figures").iterdir():
        pixels = cv2.imread(str(file))
        assert pixels is not None
        assert np.std(pixels) > 1.0, f"{file.name} is blank"
    assert "skipped" not in screen


def test_figures_without_pictures_are_named_in_one_line(tmp_path: Path) -> None:
    run, recording = perfect_run(tmp_path, ("labels",))
    lines = [line for line in report(run, recording).splitlines() if line.startswith("skipped")]
    assert len(lines) == 1
    assert "fig15_local_map_r1.png" in lines[0]
    assert "r1_connected.png" in lines[0]
    assert "fig04" not in lines[0]
    assert (run / "figures" / "fig18_global_map.png").is_file()


def test_a_picture_that_is_none_is_named(tmp_path: Path) -> None:
    run, recording = perfect_run(tmp_path, VIEWS)
    (run / "pictures" / "r1_labels.png").write_bytes(b"no picture")
    with pytest.raises(RecordingError, match=r"r1_labels\.png: is no picture"):
        report(run, recording)


def test_a_run_that_was_scored_before_is_scored_anew(tmp_path: Path) -> None:
    run, recording = perfect_run(tmp_path)
    assert report(run, recording) == report(run, recording)


def test_a_run_whose_robots_were_told_no_start_is_scored_in_its_own_frame(tmp_path: Path) -> None:
    run, recording = perfect_run(tmp_path)
    run_from_arena = Pose2(0.7, -1.2, 2.5)
    write_perfect_run(run, moved(read_truth(recording), run_from_arena))
    (run / "config").mkdir()
    (run / "config" / "mapserver.toml").write_text('robots = [{ name = "r1" }, { name = "r2" }]', encoding="utf-8")
    evaluation = evaluate(run, recording)
    assert evaluation.live.mean.distance_m.max == pytest.approx(0.0, abs=1e-6)
    assert evaluation.live.mean.heading_rad.max == pytest.approx(0.0, abs=1e-6)
    assert evaluation.map.iou.worst == pytest.approx(1.0, abs=1e-6)
    assert document(evaluation)["frame"] == "run, team aligned"
    assert "aligned by one rigid motion" in " ".join(report(run, recording).split())


def test_a_robot_that_joined_late_is_scored_from_then_on_and_the_delay_is_told(tmp_path: Path) -> None:
    run, recording = perfect_run(tmp_path)
    path = read_truth(recording).trajectories["r2"]
    write_tum(run / "trajectories" / "r2.tum", Trajectory(path.stamps_ns[2:], path.poses[2:]))
    evaluation = evaluate(run, recording)
    assert evaluation.live.robots["r2"].joined_s == pytest.approx(2e-9 * STEP_NS)
    assert evaluation.live.mean.distance_m.max == pytest.approx(0.0, abs=1e-9)
    assert evaluation.live.mean.matched == evaluation.live.mean.expected - 2
    assert "found their places: r2 after" in report(run, recording)
