"""A team of which most robots do not know where they start, and what each sees of the others."""

from __future__ import annotations

from collections.abc import Collection, Mapping

import numpy as np

from mapserver.batching import Batch
from mapserver.config import RobotSettings
from mapserver.pipeline import MapPipeline, Merged
from protocol.fields import pose_tuple
from protocol.geometry import Pose2
from protocol.messages import LocalMap, Region
from protocol.stage_clock import StageClock
from tests.unit.mapserver.worlds import MOTION_SIGMA, STEP_NS, local_map, region_of, sighting_of, smear_of

SIGHTING_SIGMA_M = 2e-3
BOX_HEIGHT_M = 0.15

Seen = Collection[tuple[str, str]]  # observer and target


class Team:
    """Robots at their true poses; r1 alone is told where it starts. Who is `seen` by whom is for the test to say: everybody, if None."""

    def __init__(self, poses: Mapping[str, Pose2], seen: Seen | None = None, strangers: Collection[Pose2] = (), seed: int = 1) -> None:
        self.poses, self._seen, self._strangers = dict(poses), seen, strangers
        self._random = np.random.default_rng(seed)
        self.pipeline = MapPipeline(
            [RobotSettings(name=robot, initial_pose=pose_tuple(pose) if robot == "r1" else None) for robot, pose in poses.items()],
            StageClock(),
        )
        self._odometry = {robot: Pose2.identity() for robot in poses}
        self.boxes: list[np.ndarray] = []
        self._step = -1

    def step(self, motion: Pose2 | Mapping[str, Pose2] | None = None) -> Merged:
        """Move all by the same motion, or each by its own (not at the first call), and merge what they report."""
        self._step += 1
        motions = motion if isinstance(motion, Mapping) else dict.fromkeys(self.poses, motion or Pose2.identity())
        moved = {robot: self._move(robot, motions.get(robot, Pose2.identity())) for robot in self.poses}
        return self.pipeline.step(
            Batch((self._step + 1) * STEP_NS, tuple(self._local_map(robot, motion) for robot, motion in sorted(moved.items())))
        )

    def drive(self, steps: int, motion: Pose2 | Mapping[str, Pose2] | None = None) -> Merged:
        """Take some steps alike and return what came of the last."""
        for _ in range(steps):
            merged = self.step(motion)
        return merged

    def error_m(self, merged: Merged, robot: str) -> float:
        """Return how far a robot's pose is from the true one."""
        [pose] = [each for each in merged.poses.robots if each.robot == robot]
        return float(np.hypot(*np.subtract(pose.arena_from_body[:2], self.poses[robot][:2])))

    def _move(self, robot: str, motion: Pose2) -> Pose2:
        if self._step == 0:
            return Pose2.identity()
        self.poses[robot] = self.poses[robot] @ motion
        noise = self._random.normal(0.0, MOTION_SIGMA) if motion != Pose2.identity() else np.zeros(3)
        measured = motion @ Pose2.exp(noise)
        self._odometry[robot] = self._odometry[robot] @ measured
        return measured

    def _local_map(self, robot: str, motion: Pose2) -> LocalMap:
        eye = self.poses[robot]
        targets = [pose for other, pose in self.poses.items() if other != robot and (self._seen is None or (robot, other) in self._seen)]
        near = [pose for pose in self._strangers if np.hypot(pose.x_m - eye.x_m, pose.y_m - eye.y_m) < 1.5]
        sightings = [sighting_of(eye, pose, error_m=self._error_m()) for pose in [*targets, *near]]
        return local_map(robot, self._step, motion=motion, odom=self._odometry[robot], sightings=sightings, regions=self._regions(eye))

    def _regions(self, eye: Pose2) -> list[Region]:
        near = [box for box in self.boxes if np.hypot(*(box.mean(axis=0) - eye[:2])) < 1.5]
        return [region_of(smear_of(box, BOX_HEIGHT_M, eye), eye, height_m=BOX_HEIGHT_M) for box in near]

    def _error_m(self) -> tuple[float, float]:
        x_m, y_m = self._random.normal(0.0, SIGHTING_SIGMA_M, 2)
        return float(x_m), float(y_m)
