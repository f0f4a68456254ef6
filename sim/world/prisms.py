"""Upright solids with flat sides: in one colour each, or with pictures on them."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from protocol.geometry import Array, Pose2
from sim.world.faces import MARGIN, Faces
from sim.world.silhouettes import facing, following
from sim.world.textures import Texture
from sim.world.view import BARELY, Field, Sight


@dataclass(frozen=True, eq=False)
class Plain:
    """A solid with flat sides, each in one colour."""

    corners_m: Array  # (n, 2) [arena]
    height_m: float
    bgr: Texture  # (n + 1, 3) of the sides, and of the top

    def footprint(self, body_from_arena: Pose2) -> Array:
        """Return its footprint; see `Solid`."""
        return body_from_arena.apply(self.corners_m)

    def colours(self, sight: Sight, body_from_arena: Pose2) -> Texture:
        """Return its colours; see `Solid`."""
        return self.bgr[_met(self.footprint(body_from_arena), self.height_m, sight)[1]]


@dataclass(frozen=True, eq=False)
class Prism:
    """A solid with flat sides and pictures on them. The top's picture has its left border along the first side."""

    corners_m: Array  # (n, 2) [arena]
    height_m: float
    faces: Faces  # the sides, and the top

    def footprint(self, body_from_arena: Pose2) -> Array:
        """Return its footprint; see `Solid`."""
        return body_from_arena.apply(self.corners_m)

    def colours(self, sight: Sight, body_from_arena: Pose2) -> Texture:
        """Return its colours; see `Solid`."""
        corners = self.footprint(body_from_arena)
        length, face = _met(corners, self.height_m, sight)
        level = self.faces.level(float(length[length.shape[0] // 2, length.shape[1] // 2]) / sight.px_per_rad)
        x, y, z = sight.points(length)
        columns, rows = np.zeros_like(z), np.float32(self.height_m) - z
        edge = following(corners) - corners
        along = edge / np.hypot(edge[:, 0], edge[:, 1])[:, None]
        for side in np.flatnonzero(facing(corners, sight.eye_m[:2])).tolist():
            across = _along(along[side], corners[side], x, y) + np.float32(level.columns[side] * level.texel_m)
            np.putmask(columns, face == side, across)
        if self.height_m < sight.eye_m[2]:
            over, top = face == len(corners), np.float32(level.columns[-1] * level.texel_m)
            np.putmask(columns, over, _along(along[0], corners[0], x, y) + top)
            np.putmask(rows, over, _along(np.array([-along[0, 1], along[0, 0]]), corners[0], x, y))
        scale, half = np.float32(1.0 / level.texel_m), np.float32(0.5)
        columns, rows = scale * columns - half, scale * rows + (np.float32(MARGIN) - half)
        return np.asarray(cv2.remap(level.picture, columns, rows, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE), np.uint8)


def _met(corners: Array, height_m: float, sight: Sight) -> tuple[Field, NDArray[np.uint8]]:
    """Return how far rays go to a prism and which face they meet, its number of sides being that of the top.

    A ray enters a convex solid where it crosses the last of the planes that face it.
    """
    way = following(corners) - corners
    normal = np.stack([way[:, 1], -way[:, 0]], axis=-1) / np.hypot(way[:, 0], way[:, 1])[:, None]
    gaps = ((corners - sight.eye_m[:2]) * normal).sum(axis=1)
    x, y, _ = sight.rays
    length, face = np.zeros(x.shape, np.float32), np.zeros(x.shape, np.uint8)
    for side in np.flatnonzero(facing(corners, sight.eye_m[:2])).tolist():
        nx, ny = normal[side].astype(np.float32)
        _enter(length, face, np.asarray(np.float32(gaps[side]) / np.minimum(nx * x + ny * y, BARELY)), side)
    if height_m < sight.eye_m[2]:
        _enter(length, face, sight.length_to_level(height_m), len(corners))
    return length, face


def _enter(length: Field, face: NDArray[np.uint8], ahead: Field, number: int) -> None:
    """Take a plane for those rays that cross it later than what they crossed before."""
    np.putmask(face, ahead > length, number)
    np.maximum(length, ahead, out=length)


def _along(way: Array, start: Array, x: Field, y: Field) -> Field:
    """Return how far along a unit way from a start, (2,) each, points lie [m]."""
    wx, wy = way.astype(np.float32)
    return np.asarray(wx * x + wy * y - np.float32(way @ start), np.float32)
