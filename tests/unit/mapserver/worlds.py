"""Worlds for the map server's tests: local maps as honest agents would send them, with projections of their own."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal

import cv2
import numpy as np

from mapserver.batching import Batch
from mapserver.config import RobotSettings
from mapserver.mapping.poses.track import Start
from protocol.fields import Packed, covariance_tuple, pose_tuple
from protocol.geometry import Array, Pose2
from protocol.messages import Identity, LocalMap, Region, Sighting

CAMERA_HEIGHT_M = 0.5
BODY_RADIUS_M = 0.075
MOTION_SIGMA = np.array([5e-4, 5e-4, 5e-4])
SIGHTING_VARIANCE = (4e-6, 0.0, 4e-6)
STEP_NS = 200_000_000
Motion = Literal["static", "moving", "unknown"]
NOBODY = Identity(kind="none")


def sighting_of(observer: Pose2, target: Pose2, identity: Identity = NOBODY, error_m: tuple[float, float] = (0.0, 0.0)) -> Sighting:
    """Return what an observer sees of a robot's base, its place wrong by `error_m` in the observer's frame."""
    x_m, y_m = observer.inverse().apply(target[:2]) + np.array(error_m)
    return Sighting(range_m=math.hypot(x_m, y_m), bearing_rad=math.atan2(y_m, x_m), covariance=SIGHTING_VARIANCE, identity=identity)


def local_map(
    robot: str,
    seq: int,
    *,
    motion: Pose2 | None = None,
    odom: Pose2 | None = None,
    sightings: Sequence[Sighting] = (),
    regions: Sequence[Region] = (),
    epoch: int = 0,
    stamp_ns: int | None = None,
    floor_range_m: float = 2.0,
) -> LocalMap:
    """Return a local map whose stamp follows from its number."""
    return LocalMap(
        robot=robot,
        epoch=epoch,
        seq=seq,
        stamp_ns=(seq + 1) * STEP_NS if stamp_ns is None else stamp_ns,
        picture="used",
        odom_from_body=pose_tuple(odom or Pose2.identity()),
        previous_from_body=pose_tuple(motion or Pose2.identity()),
        motion_covariance=covariance_tuple(np.diag(MOTION_SIGMA**2)),
        floor_range_m=floor_range_m,
        body_radius_m=BODY_RADIUS_M,
        camera_height_m=CAMERA_HEIGHT_M,
        regions=tuple(regions),
        sightings=tuple(sightings),
    )


def smear_of(footprint_m: Array, height_m: float, eye: Pose2) -> Array:
    """Return the outline, shape (n, 2) [m; arena], under which an upright prism hides the floor from a camera above `eye`."""
    eye_m = np.array(eye[:2])
    top_m = eye_m + (footprint_m - eye_m) * CAMERA_HEIGHT_M / (CAMERA_HEIGHT_M - height_m)
    hull = cv2.convexHull(np.vstack([footprint_m, top_m]).astype(np.float32))[:, 0, :]
    return np.asarray(hull, dtype=np.float64)


def region_of(
    outline_m: Array, eye: Pose2, motion: Literal["static", "moving", "unknown"] = "static", height_m: float | None = None
) -> Region:
    """Return an arena outline as the robot at `eye` reports it."""
    body = eye.inverse().apply(outline_m)
    centre = Packed.of_metres(body.mean(axis=0)[None])
    return Region(label=1, motion=motion, outline=Packed.of_metres(body), centre=centre, height_m=height_m)


def rectangle(x_m: float, y_m: float, width_m: float, depth_m: float) -> Array:
    """Return the corners of an upright rectangle around a centre, counter-clockwise."""
    return np.array([x_m, y_m]) + 0.5 * np.array([[-width_m, -depth_m], [width_m, -depth_m], [width_m, depth_m], [-width_m, depth_m]])


def settings(name: str, pose: Pose2) -> RobotSettings:
    """Return the configuration of a robot that is set down exactly."""
    return RobotSettings(name=name, initial_pose=pose_tuple(pose))


class Swarm:
    """Robots that drive on arcs, measure their motion with noise, and see each other."""

    def __init__(self, starts: dict[str, Pose2], sigmas: dict[str, tuple[float, float, float]], seed: int = 1) -> None:
        self._random = np.random.default_rng(seed)
        self.starts = {robot: Start(pose, sigmas[robot]) for robot, pose in starts.items()}
        self.poses = {robot: self._true_start(self.starts[robot]) for robot in starts}
        self._odometry = {robot: Pose2.identity() for robot in starts}
        self._seq = -1

    def _true_start(self, start: Start) -> Pose2:
        """Return a start that is wrong by one standard deviation in everything."""
        x, y, theta = np.array(start.sigma) * self._random.choice([-1.0, 1.0], 3)
        return Pose2(start.arena_from_body.x_m + x, start.arena_from_body.y_m + y, start.arena_from_body.theta_rad + theta)

    def drive(
        self, motions: dict[str, Pose2] | None = None, false_sightings: Sequence[Sighting] = (), blind: bool = False
    ) -> list[LocalMap]:
        """Move all robots (not at the first call) and return their local maps; r1 also reports `false_sightings`."""
        self._seq += 1
        measured = {robot: self._move(robot, (motions or {}).get(robot, Pose2.identity())) for robot in self.poses}
        return [
            local_map(
                robot,
                self._seq,
                motion=measured[robot],
                odom=self._odometry[robot],
                sightings=[*(() if blind else self._seen_from(robot)), *(false_sightings if robot == "r1" else ())],
            )
            for robot in sorted(self.poses)
        ]

    def _move(self, robot: str, motion: Pose2) -> Pose2:
        if self._seq == 0:
            return Pose2.identity()
        self.poses[robot] = self.poses[robot] @ motion
        measured = motion @ Pose2.exp(self._random.normal(0.0, MOTION_SIGMA))
        self._odometry[robot] = self._odometry[robot] @ measured
        return measured

    def _seen_from(self, robot: str) -> list[Sighting]:
        return [
            sighting_of(self.poses[robot], pose, error_m=tuple(self._random.normal(0.0, 2e-3, 2)))
            for other, pose in self.poses.items()
            if other != robot
        ]


def batch(local_maps: Sequence[LocalMap]) -> Batch:
    """Return local maps of one stamp as a batch."""
    return Batch(local_maps[0].stamp_ns, tuple(local_maps))
