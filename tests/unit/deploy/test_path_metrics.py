"""Path errors against numbers worked by hand."""

import math

import numpy as np
import pytest

from deploy.evaluation.path_metrics import MeanMax, aligned_rmse_m, match_path, mean_score, score_path
from deploy.evaluation.tum import Trajectory, no_poses
from protocol.geometry import Pose2
from tests.unit.deploy.worlds import STEP_NS, trajectory


def test_errors_are_means_and_maxima_of_absolute_differences() -> None:
    truth = trajectory([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (2.0, 0.0, 0.0)])
    estimate = trajectory([(0.0, 0.0, 0.0), (1.03, -0.04, 0.1), (1.94, 0.08, -0.2)])
    score = score_path(match_path(estimate, truth))
    assert score.x_m == pytest.approx((0.03, 0.06))  # 0, 3, 6 cm
    assert score.y_m == pytest.approx((0.04, 0.08))  # 0, 4, 8 cm
    assert score.distance_m == pytest.approx((0.05, 0.10))  # 0, 5, 10 cm
    assert score.heading_rad == pytest.approx((0.1, 0.2))
    assert (score.matched, score.expected) == (3, 3)


def test_heading_errors_are_taken_the_short_way_round() -> None:
    score = score_path(match_path(trajectory([(0.0, 0.0, 3.1)]), trajectory([(0.0, 0.0, -3.1)])))
    assert score.heading_rad.max == pytest.approx(2 * math.pi - 6.2)


def test_poses_are_matched_by_stamp_and_what_has_no_match_is_counted() -> None:
    truth = trajectory([(0.1 * i, 0.0, 0.0) for i in range(5)])
    late = Trajectory(truth.stamps_ns[[1, 3, 4]] + np.array([999, -999, STEP_NS // 2]), truth.poses[[1, 3, 4]])
    path = match_path(late, truth)
    assert path.stamps_ns.tolist() == truth.stamps_ns[[1, 3]].tolist()
    assert path.expected == 5
    assert score_path(path).distance_m.max == 0.0


def test_alignment_takes_out_one_motion_of_the_whole_path() -> None:
    poses = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 0.5, 0.0), (0.3, 0.9, 0.0)]
    moved = Pose2(0.4, -0.2, 0.7)
    truth = trajectory([moved @ Pose2(*pose) for pose in poses])
    path = match_path(trajectory(poses), truth)
    assert score_path(path).distance_m.mean > 0.3
    assert aligned_rmse_m(path) == pytest.approx(0.0, abs=1e-12)


def test_alignment_does_not_scale() -> None:
    # Two points 2 m apart against two points 1 m apart: centred, each is 0.5 m off.
    path = match_path(trajectory([(-1.0, 0.0, 0.0), (1.0, 0.0, 0.0)]), trajectory([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0)]))
    assert aligned_rmse_m(path) == pytest.approx(0.5)


def test_the_team_is_the_mean_of_the_robots_and_the_largest_maximum() -> None:
    truth = trajectory([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0)])
    near = score_path(match_path(trajectory([(0.0, 0.0, 0.0), (1.02, 0.0, 0.0)]), truth))  # mean 1 cm, largest 2 cm
    far = score_path(match_path(trajectory([(0.0, 0.03, 0.0), (1.0, 0.03, 0.0)]), truth))  # 3 cm everywhere
    team = mean_score([near, far])
    assert team.distance_m == pytest.approx((0.02, 0.03))
    assert team.matched == team.expected == 4


def test_a_robot_that_was_never_placed_spoils_the_mean() -> None:
    truth = trajectory([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0)])
    lost = score_path(match_path(no_poses(), truth))
    assert (lost.matched, lost.expected) == (0, 2)
    assert all(math.isnan(value) for value in (*lost.distance_m, lost.aligned_rmse_m))
    assert math.isnan(mean_score([lost, score_path(match_path(truth, truth))]).distance_m.mean)


def test_a_perfect_path_has_no_error() -> None:
    truth = trajectory([(0.3 * i, 0.1 * i * i, 0.5 * i) for i in range(6)])
    score = score_path(match_path(truth, truth))
    assert score.distance_m == score.heading_rad == MeanMax(0.0, 0.0)
    assert score.aligned_rmse_m == pytest.approx(0.0, abs=1e-12)
