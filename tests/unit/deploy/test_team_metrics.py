"""Errors of a whole team after one motion of all its paths together."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from deploy.evaluation.mrclam_truth import is_mrclam, read_mrclam_truth, true_positions
from deploy.evaluation.team_metrics import score_together
from deploy.evaluation.tum import Trajectory
from protocol.errors import RecordingError
from protocol.geometry import Pose2
from tests.mrclam_folder import START_S, true_pose, write_folder

STAMPS = np.arange(0, 10_000_000_000, 100_000_000, dtype=np.int64)
MOVED = Pose2(3.0, -1.0, 2.5)


def circle(radius_m: float, centre_m: tuple[float, float]) -> Trajectory:
    angles = STAMPS * 1e-9 * 0.3
    poses = np.column_stack([centre_m[0] + radius_m * np.cos(angles), centre_m[1] + radius_m * np.sin(angles), angles])
    return Trajectory(STAMPS, poses)


def moved(path: Trajectory, motion: Pose2) -> Trajectory:
    return Trajectory(path.stamps_ns, np.column_stack([motion.apply(path.poses[:, :2]), path.poses[:, 2] + motion.theta_rad]))


TRUTH = {"r1": circle(1.0, (0.0, 0.0)), "r2": circle(0.5, (2.0, 1.0))}


def test_a_team_that_is_moved_as_a_whole_has_no_error() -> None:
    score = score_together({robot: moved(path, MOVED) for robot, path in TRUTH.items()}, TRUTH)
    assert score.team_rmse_m == pytest.approx(0.0, abs=1e-9)
    assert score.matched == score.expected == {"r1": 100, "r2": 100}


def test_one_robot_that_is_moved_alone_is_an_error_that_no_motion_takes_out() -> None:
    score = score_together({"r1": TRUTH["r1"], "r2": moved(TRUTH["r2"], Pose2(0.2, 0.0, 0.0))}, TRUTH)
    assert 0.05 < score.team_rmse_m < 0.1
    assert score.largest_rmse_m == max(score.robots_rmse_m.values())


def test_a_wrong_scale_is_an_error() -> None:
    larger = {robot: Trajectory(path.stamps_ns, path.poses * (1.1, 1.1, 1.0)) for robot, path in TRUTH.items()}
    assert score_together(larger, TRUTH).team_rmse_m > 0.05


def test_a_robot_without_a_path_has_no_figure_and_spoils_no_others() -> None:
    score = score_together({"r1": TRUTH["r1"]}, TRUTH)
    assert score.team_rmse_m == pytest.approx(0.0, abs=1e-9)
    assert math.isnan(score.robots_rmse_m["r2"])
    assert score.largest_rmse_m == pytest.approx(0.0, abs=1e-9)


def test_the_truth_is_known_between_its_rows_and_not_in_its_gaps() -> None:
    rows = np.array([0, 400_000_000, 2_400_000_000, 2_500_000_000], dtype=np.int64)
    truth = Trajectory(rows, np.column_stack([rows * 1e-9, 2e-9 * rows, np.zeros(4)]))
    asked = np.array([-1, 200_000_000, 1_000_000_000, 2_450_000_000, 2_500_000_001], dtype=np.int64)
    positions = true_positions(truth, asked)
    assert positions[[1, 3]] == pytest.approx(np.array([[0.2, 0.4], [2.45, 4.9]]))
    assert np.isnan(positions[[0, 2, 4]]).all()


def test_the_truth_of_a_folder_is_read_by_robot(tmp_path: Path) -> None:
    folder = write_folder(tmp_path / "mrclam", 2.0)
    assert is_mrclam(folder)
    truth = read_mrclam_truth(folder)
    assert list(truth) == ["r1", "r2", "r3"]
    assert truth["r2"].poses[50] == pytest.approx(true_pose(2, 1.0), abs=1e-6)
    assert truth["r2"].stamps_ns[50] == round(START_S + 1.0) * 10**9


def test_a_folder_without_truth_is_named(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"holds no Robot1_Groundtruth\.dat"):
        read_mrclam_truth(tmp_path)
