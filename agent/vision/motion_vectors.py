"""Motion vectors: where points were and are, on the picture and, corrected for the lens, on the floor.

Only the start and end points are mapped forwards (section III.4 of the paper), never the picture.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from agent.vision.floor_projection import FloorProjection
from protocol.geometry import Array, Pose2


@dataclass(frozen=True, eq=False)
class MotionVectors:
    """n motion vectors. A point at or above the horizon has no place on the floor: NaN there."""

    starts_px: Array  # (n, 2) in the previous picture
    ends_px: Array  # (n, 2) in this picture
    starts_m: Array  # (n, 2) [m; previous body]
    ends_m: Array  # (n, 2) [m; body]
    labels: NDArray[np.int32]  # (n,) 0: floor

    def __len__(self) -> int:
        """Count the vectors."""
        return len(self.labels)

    @property
    def vectors_px(self) -> Array:
        """Motion on the picture, shape (n, 2)."""
        return self.ends_px - self.starts_px

    @property
    def vectors_m(self) -> Array:
        """Corrected motion as the robot sees it, shape (n, 2) [m]: what is static moves against the robot."""
        return self.ends_m - self.starts_m

    def select(self, rows: NDArray[np.generic]) -> MotionVectors:
        """Return the vectors of a mask or of indices."""
        return MotionVectors(self.starts_px[rows], self.ends_px[rows], self.starts_m[rows], self.ends_m[rows], self.labels[rows])


def correct_vectors(starts_px: Array, ends_px: Array, labels: NDArray[np.int32], projection: FloorProjection) -> MotionVectors:
    """Correct the start and end points, both shape (n, 2) [px], of labelled (n,) vectors by forward mapping onto the floor."""
    on_floor = projection.floor_from_pixels(np.concatenate([starts_px, ends_px]))
    return MotionVectors(starts_px, ends_px, on_floor[: len(starts_px)], on_floor[len(starts_px) :], labels)


def predict_ends(starts_px: Array, previous_from_body: Pose2, projection: FloorProjection, reach_m: float) -> Array:
    """Predict where static points, shape (n, 2) [px], of the previous picture are in this one: (n, 2) [px]; NaN where they leave the view.

    Points are taken to lie on the floor, or `reach_m` away where their ray does not meet it sooner.
    """
    points = projection.points_from_pixels(starts_px, reach_m)
    points[:, :2] = previous_from_body.inverse().apply(points[:, :2])
    return projection.pixels_from_points(points)


def no_vectors() -> tuple[MotionVectors, NDArray[np.bool_]]:
    """Return no motion vectors, and the mask of those kept."""
    points = np.zeros((0, 2))
    return MotionVectors(points, points, points, points, np.zeros(0, np.int32)), np.zeros(0, np.bool_)
