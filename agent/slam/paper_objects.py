"""What the paper makes of corrected vectors: the robot's own translation, robots told from obstacles, and objects by convex hulls."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from agent.slam.regions import SeenRegion
from agent.vision.floor_projection import FloorProjection
from agent.vision.hull import centre_of_polygon, hulls_by_label
from agent.vision.motion_vectors import MotionVectors
from protocol.geometry import Array, Pose2

LEAST_MOTION_M = 0.004  # with less than this of the robot itself, nothing can be told
STATIC_SHARE = 0.5  # of the robot's own way, from which the way that a label tells makes it static


def static_translation(vectors: MotionVectors, predicted: Pose2) -> Array:
    """Return the robot's own translation, (2,) [m; previous body]: the median over all vectors of static objects.

    The wheels' own translation where no label is static.
    """
    static = ~np.isin(vectors.labels, list(tell_robots(vectors, predicted))) & (vectors.labels > 0)
    if not static.any():
        return np.array([predicted.x_m, predicted.y_m])
    return np.asarray(np.median(translations(vectors, predicted)[static], axis=0))


def tell_robots(vectors: MotionVectors, previous_from_body: Pose2) -> set[int]:
    """Return the labels that move along with the robot (IV.2): "obstacles have a large magnitude, opposite to the motion of the robots"."""
    way = np.array([previous_from_body.x_m, previous_from_body.y_m])
    length = float(np.hypot(*way))
    if length < LEAST_MOTION_M:
        return set()
    told = translations(vectors, previous_from_body) @ way / length
    labels = np.unique(vectors.labels[vectors.labels > 0])
    return {int(label) for label in labels if np.median(told[vectors.labels == label]) < STATIC_SHARE * length}


def translations(vectors: MotionVectors, previous_from_body: Pose2) -> Array:
    """Return the robot's translation that each vector tells, (n, 2) [m; previous body], the turn of Eq. 1 taken out.

    A static point moves from start to end = R^T (start - t), so that t = start - R end.
    """
    return np.asarray(vectors.starts_m - vectors.ends_m @ previous_from_body.rotation().T)


def describe(
    corners_px: Array, labels: NDArray[np.int32], robots: set[int], projection: FloorProjection, reach_m: float
) -> list[SeenRegion]:
    """Return the objects of a frame: the convex hull of the corrected corners, (n, 2) [px], of every label, with its centre by Eq. 8."""
    floor = projection.floor_from_pixels(corners_px)
    in_reach = np.hypot(*np.nan_to_num(floor, nan=np.inf).T) < reach_m
    hulls = hulls_by_label(floor[in_reach], labels[in_reach])
    return [_object(label, hull, label in robots) for label, hull in hulls.items() if len(hull) >= 3]


def _object(label: int, hull: Array, is_robot: bool) -> SeenRegion:
    motion: Literal["static", "moving"] = "moving" if is_robot else "static"
    return SeenRegion(label, hull, centre_of_polygon(hull), motion, None, flat=False)
