"""From what was seen to what is said: the local map and the motion-vector summary of one frame."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from agent.slam.ego_motion import Motion
from agent.slam.landmarks import Recognition
from agent.slam.regions import SeenRegion
from agent.vision.groups import Groups
from agent.vision.motion_vectors import MotionVectors as Vectors
from agent.vision.robot_fit import RobotFit
from protocol.fields import Packed, covariance_tuple, pose_tuple
from protocol.geometry import Array
from protocol.messages import Identity, LocalMap, MotionVectors, Region, Revisit, Sighting

MOST_OUTLINE_POINTS = 500  # of all regions together, so that a local map and its vectors stay under 4 kB
FINEST_M, COARSER = 0.002, 1.6  # outlines are simplified to this tolerance, and further in such steps where they are too long
ANYONE = Identity(kind="none")


@dataclass(frozen=True)
class Frame:
    """Which frame of which robot is reported."""

    robot: str
    epoch: int
    seq: int
    stamp_ns: int


@dataclass(frozen=True)
class Surroundings:
    """What the floor around the robot looked like: how far it was judged, what was found on it, and whether it was recognised."""

    floor_range_m: float
    regions: list[SeenRegion]
    robots: list[RobotFit]
    recognition: Recognition | None = None


def local_map(frame: Frame, motion: Motion, seen: Surroundings | None, body_range_m: float, camera_height_m: float) -> LocalMap:
    """Return the message; `seen` is None where the picture was dropped, or shows what is no floor to be mapped."""
    regions = [] if seen is None else [region for region in seen.regions if not region.flat]
    return LocalMap(
        robot=frame.robot,
        epoch=frame.epoch,
        seq=frame.seq,
        stamp_ns=frame.stamp_ns,
        picture="dropped" if seen is None else "used",
        odom_from_body=pose_tuple(motion.odom_from_body),
        previous_from_body=pose_tuple(motion.previous_from_body),
        motion_covariance=covariance_tuple(motion.covariance),
        floor_range_m=0.0 if seen is None else seen.floor_range_m,
        body_radius_m=body_range_m,
        camera_height_m=camera_height_m,
        regions=tuple(_region(region, outline) for region, outline in zip(regions, _fitting_outlines(regions), strict=True)),
        sightings=() if seen is None else tuple(_sighting(robot) for robot in seen.robots),
        revisits=() if seen is None or seen.recognition is None else (_revisit(seen.recognition),),
        lifts=motion.lifts,
    )


def motion_summary(frame: Frame, vectors: Vectors, kept: NDArray[np.bool_]) -> MotionVectors:
    """Return the summary: per label the median of the vectors, (n,), that were kept."""
    labelled = kept & (vectors.labels > 0)
    of_label = Groups.of(vectors.labels[labelled])
    starts_m, vectors_m = (
        np.column_stack([of_label.medians(axis) for axis in both[labelled].T]) for both in (vectors.starts_m, vectors.vectors_m)
    )
    return MotionVectors(
        robot=frame.robot,
        epoch=frame.epoch,
        seq=frame.seq,
        stamp_ns=frame.stamp_ns,
        labels=Packed.of(of_label.labels, "i2"),
        counts=Packed.of(of_label.sizes, "i2"),
        starts=Packed.of_metres(starts_m),
        vectors=Packed.of_metres(vectors_m),
    )


def _fitting_outlines(regions: list[SeenRegion]) -> list[Array]:
    """Return the regions' outlines, simplified just as far as the message's size demands."""
    tolerance_m = FINEST_M
    outlines = [_simplified(region.outline_m, tolerance_m) for region in regions]
    while sum(map(len, outlines)) > MOST_OUTLINE_POINTS and tolerance_m < 1.0:
        tolerance_m *= COARSER
        outlines = [_simplified(region.outline_m, tolerance_m) for region in regions]
    return outlines


def _simplified(outline: Array, tolerance_m: float) -> Array:
    """Return an outline, (n, 2) [m], with fewer points, none of the old ones farther than the tolerance from it; three at least."""
    simple = cv2.approxPolyDP(outline.astype(np.float32)[:, None], tolerance_m, True)[:, 0]
    return simple.astype(np.float64) if len(simple) >= 3 else outline[:: max(1, len(outline) // 3)][:3]


def _region(region: SeenRegion, outline: Array) -> Region:
    return Region(
        label=region.label,
        motion=region.motion,
        outline=Packed.of_metres(outline),
        centre=Packed.of_metres(region.centre_m[None]),
        height_m=region.height_m,
    )


def _revisit(recognition: Recognition) -> Revisit:
    return Revisit(
        stamp_ns=recognition.stamp_ns,
        then_from_body=pose_tuple(recognition.then_from_body),
        covariance=covariance_tuple(recognition.covariance),
    )


def _sighting(robot: RobotFit) -> Sighting:
    """Return range and bearing of a robot, with their covariance carried over from x and y."""
    x, y = robot.centre_m
    range_m = float(np.hypot(x, y))
    jacobian = np.array([[x / range_m, y / range_m], [-y / range_m**2, x / range_m**2]])
    covariance = jacobian @ robot.covariance @ jacobian.T
    return Sighting(
        range_m=range_m,
        bearing_rad=float(np.arctan2(y, x)),
        covariance=(float(covariance[0, 0]), float(covariance[0, 1]), float(covariance[1, 1])),
        identity=ANYONE,
    )
