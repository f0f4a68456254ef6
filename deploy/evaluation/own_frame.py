"""The truth in a run's own frame: where no robot was told its start, the run's arena is the first robot's, not the recording's."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import shapely

from deploy.evaluation.path_metrics import match_path
from deploy.evaluation.truth import Truth
from deploy.evaluation.tum import Trajectory, no_poses
from protocol.geometry import Pose2, wrap_angle


def run_from_arena(estimates: Mapping[str, Trajectory], truth: Truth) -> Pose2:
    """Return the SE(2) motion of the whole team's true paths onto the estimated ones (Umeyama 1991, eq. 34 to 43, without the scale)."""
    paths = [match_path(estimates.get(robot, no_poses()), true) for robot, true in truth.trajectories.items()]
    estimate, true = (np.concatenate(poses)[:, :2] @ (1.0, 1.0j) for poses in zip(*((p.estimate, p.truth) for p in paths), strict=True))
    if not len(true):
        return Pose2.identity()
    theta = float(np.angle(np.vdot(true - true.mean(), estimate - estimate.mean())))
    origin = estimate.mean() - np.exp(1j * theta) * true.mean()
    return Pose2(float(origin.real), float(origin.imag), theta)


def moved(truth: Truth, run_from_arena: Pose2) -> Truth:
    """Return the truth in the run's frame."""
    return replace(
        truth,
        arena_bounds=_moved_polygon(truth.arena_bounds, run_from_arena),
        obstacles=tuple(replace(each, footprint=_moved_polygon(each.footprint, run_from_arena)) for each in truth.obstacles),
        trajectories={robot: _moved_path(path, run_from_arena) for robot, path in truth.trajectories.items()},
    )


def _moved_polygon(polygon: shapely.Polygon, a_from_b: Pose2) -> shapely.Polygon:
    return shapely.transform(polygon, a_from_b.apply)


def _moved_path(path: Trajectory, a_from_b: Pose2) -> Trajectory:
    places = a_from_b.apply(path.poses[:, :2])
    headings = [wrap_angle(theta + a_from_b.theta_rad) for theta in path.poses[:, 2].tolist()]
    return Trajectory(path.stamps_ns, np.column_stack([places, headings]))
