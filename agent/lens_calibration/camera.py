"""A radially symmetric camera with all derivatives that an adjustment needs. Camera frame as in agent/vision/lens.py."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np

from agent.lens_calibration.radial import RadialFamily
from protocol.geometry import Array

FRAME = 4  # fx, fy, cx, cy: what all families share
_TINY = 1e-12
_TABLE_NODES = 2048
_NEWTON_STEPS = 2
_WIDEST_RAD = np.radians(125.0)


class BoardPose(NamedTuple):
    """Where a board is before the camera."""

    rotation: Array  # (3, 3), camera from board
    translation_m: Array  # (3,) [camera]

    def apply(self, points_m: Array) -> Array:
        """Return points (n, 3) [board] in the camera's frame."""
        return points_m @ self.rotation.T + self.translation_m

    def moved(self, step: Array) -> BoardPose:
        """Return the pose turned by step[:3] [rad; camera] about the board's origin, and shifted by step[3:] [m; camera]."""
        turn, _ = cv2.Rodrigues(np.asarray(step[:3], np.float64))
        return BoardPose(np.asarray(turn @ self.rotation), self.translation_m + step[3:])


class Drawn(NamedTuple):
    """Where points fall on the picture, with derivatives."""

    pixels: Array  # (n, 2) [px]
    by_lens: Array  # (n, 2, FRAME + parameters)
    by_pose: Array  # (n, 2, 6), by `BoardPose.moved`


@dataclass(frozen=True, eq=False)
class Camera:
    """A lens of a family: `values` are fx, fy [px / rad], cx, cy [px] and the family's own parameters."""

    family: RadialFamily
    values: Array

    def project(self, points_m: Array) -> Array:
        """Return the pixels (n, 2) of points (n, 3) [camera]."""
        off_axis = np.hypot(points_m[:, 0], points_m[:, 1])
        radius = self.family.radius(np.arctan2(off_axis, points_m[:, 2]), self.values[FRAME:]).radius
        along = points_m[:, :2] / np.maximum(off_axis, _TINY)[:, None]
        return np.asarray(self.values[2:4] + self.values[:2] * radius[:, None] * along)

    def rays(self, pixels: Array) -> Array:
        """Return unit rays (n, 3) [camera] of pixels (n, 2); beyond where the radius grows, rays at the last angle that has a pixel."""
        offset = (pixels - self.values[2:4]) / self.values[:2]
        radius = np.hypot(offset[:, 0], offset[:, 1])
        angle = self.angle(radius)
        along = offset / np.maximum(radius, _TINY)[:, None]
        return np.column_stack([np.sin(angle)[:, None] * along, np.cos(angle)])

    def angle(self, radius: Array) -> Array:
        """Return the angles [rad] to the axis that are drawn at radii (n,), given as shares of the focal length."""
        nodes = np.linspace(0.0, self.growing_to_rad, _TABLE_NODES)
        table = self.family.radius(nodes, self.values[FRAME:]).radius
        angle = np.interp(radius, table, nodes)
        for _ in range(_NEWTON_STEPS):
            drawn = self.family.radius(angle, self.values[FRAME:])
            angle = np.clip(angle - (drawn.radius - radius) / np.maximum(drawn.slope, 0.1), 0.0, nodes[-1])
        return np.asarray(angle)

    @property
    def growing_to_rad(self) -> float:
        """The angle to the axis at which the radius stops growing, or 125 degrees."""
        nodes = np.linspace(0.0, _WIDEST_RAD, _TABLE_NODES)
        radius, slope, _ = self.family.radius(nodes, self.values[FRAME:])
        grows = (slope > 0.0) & (np.diff(radius, prepend=-1.0) > 0.0)
        return float(nodes[-1] if grows.all() else nodes[max(int(np.argmin(grows)) - 1, 1)])

    def draw(self, points_m: Array, pose: BoardPose) -> Drawn:
        """Return where points (n, 3) [board] fall on the picture, with derivatives by lens and pose."""
        turned = points_m @ pose.rotation.T
        x, y, z = (turned + pose.translation_m).T
        off_axis = np.maximum(np.hypot(x, y), _TINY)
        along = np.stack([x, y], axis=-1) / off_axis[:, None]
        radius, slope, partials = self.family.radius(np.arctan2(off_axis, z), self.values[FRAME:])
        focal = self.values[:2]
        angle_by_point = np.column_stack([z[:, None] * along, -off_axis]) / (off_axis**2 + z**2)[:, None]
        across = np.stack([-along[:, 1], along[:, 0]], axis=-1)
        place_by_point = (slope[:, None] * along)[:, :, None] * angle_by_point[:, None, :]
        place_by_point[:, :, :2] += (radius / off_axis)[:, None, None] * across[:, :, None] * across[:, None, :]
        by_point = focal[None, :, None] * place_by_point
        by_pose = np.concatenate([by_point @ -_cross_matrices(turned), by_point], axis=-1)
        by_lens = np.zeros((len(x), 2, self.values.size))
        by_lens[:, [0, 1], [0, 1]] = radius[:, None] * along
        by_lens[:, [0, 1], [2, 3]] = 1.0
        by_lens[:, :, FRAME:] = (focal * along)[:, :, None] * partials[:, None, :]
        return Drawn(self.values[2:4] + focal * radius[:, None] * along, by_lens, by_pose)


def _cross_matrices(vectors: Array) -> Array:
    """Return the matrices (n, 3, 3) that take the cross product of vectors (n, 3) with what they are applied to."""
    x, y, z = vectors.T
    none = np.zeros_like(x)
    return np.stack([none, -z, y, z, none, -x, -y, x, none], axis=-1).reshape(-1, 3, 3)
