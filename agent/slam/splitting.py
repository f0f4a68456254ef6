"""Two things that touch in the picture, one behind the other, told apart by where parallax puts their corners.

A thing that goes on behind its front goes on at its height. What begins again from lower down, after a gap, and appears beyond all of the
front or is lower than that, is another thing. The farther sides of one box begin low, too, but appear beside its front's top and are
as high.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from agent.vision.robust import quantile
from protocol.geometry import Array

LEAST_GAP_IN_HEIGHTS = 0.2  # along the line of sight, between the corners of one thing and those of the next
LEAST_FRONT_CORNERS = 3
LEAST_LOW_CORNERS = 2  # of the thing behind, that stand lower than ...
OTHER_TOP = (0.3, 0.8)  # of the front's height: what reaches this high is told well enough, and is not the same thing's far side
LOW_SHARE = 0.6  # ... this share of the front's height


@dataclass(frozen=True, eq=False)
class Corners:
    """The corners of one region whose height is known."""

    appearances_m: Array  # (n, 2) where they appear on the floor [m; from the point under the camera]
    slopes: Array  # (n,) of their appearance over the camera's way: 1 - H / (H - h)

    def select(self, rows: NDArray[np.bool_]) -> Corners:
        """Return the corners of a mask, (n,)."""
        return Corners(self.appearances_m[rows], self.slopes[rows])

    def places_m(self) -> Array:
        """Return where they stand, (n, 2) [m; from the point under the camera]."""
        return np.asarray(self.appearances_m / (1.0 - self.slopes)[:, None])


class Split(NamedTuple):
    """Two things in one region."""

    range_m: float  # at which the thing behind begins to appear
    behind: NDArray[np.bool_]  # (n,) which corners are its own; some of the front's may appear as far out


def split(corners: Corners, camera_height_m: float) -> Split | None:
    """Return where and how a region's corners part; None where there is only one thing."""
    standing = np.hypot(*corners.places_m().T)
    order = np.argsort(standing)
    gaps = np.diff(standing[order])
    stretch = -corners.slopes[order]  # grows with height
    appearing = np.hypot(*corners.appearances_m[order].T)
    for after in np.argsort(-gaps):
        front, behind = slice(None, after + 1), slice(after + 1, None)
        if gaps[after] < LEAST_GAP_IN_HEIGHTS * camera_height_m:
            return None
        top, top_behind = (quantile(stretch[part], 0.9) for part in (front, behind))
        low = stretch[behind] < LOW_SHARE * top
        beyond = appearing[behind].min() > quantile(appearing[front], 0.9)
        lower = OTHER_TOP[0] * top < top_behind < OTHER_TOP[1] * top
        if (beyond or lower) and len(stretch[front]) >= LEAST_FRONT_CORNERS and int(low.sum()) >= LEAST_LOW_CORNERS:
            mask = np.zeros(len(order), np.bool_)
            mask[order[behind]] = True
            return Split(float(appearing[behind].min()), mask)
    return None


def cut(outline: Array, eye: Array, range_m: float) -> tuple[Array, Array]:
    """Cut an outline, (n, 2) [m], across the line of sight at a range from the eye, (2,); return what is nearer and what is beyond.

    Either may be empty, (0, 2). Of an outline that is not convex a half may run along the cut; its convex hull is right.
    """
    offsets = outline - eye
    middle = offsets.mean(axis=0)
    along = offsets @ (middle / max(float(np.hypot(*middle)), 1e-9)) - range_m
    return _half(outline, -along), _half(outline, along)


def _half(polygon: Array, inside: Array) -> Array:
    """Return the part of a polygon, (n, 2), where the signed distances `inside`, (n,), are not negative."""
    kept: list[Array] = []
    for here, there, d_here, d_there in zip(polygon, np.roll(polygon, -1, axis=0), inside, np.roll(inside, -1), strict=True):
        if d_here >= 0.0:
            kept.append(here)
        if (d_here >= 0.0) != (d_there >= 0.0):
            kept.append(here + (there - here) * (d_here / (d_here - d_there)))
    return np.array(kept).reshape(-1, 2)
