"""Curves to drive along, sampled finely: the leader's trail, and the lanes that followers keep beside it.

All are functions of one parameter, the arc length s of the leader's trail, so that everybody's place, speed and turn follow from how far
the leader is and how fast it goes on.
"""

from __future__ import annotations

from typing import NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike

from protocol.geometry import Array, Pose2, wrap_angle

STEP_M = 0.01  # of arc length between two samples


class Reference(NamedTuple):
    """Where a robot should be now, and how it should be moving: what a unicycle can follow exactly."""

    arena_from_body: Pose2
    speed_m_s: float
    turn_rad_s: float


class Lane(NamedTuple):
    """A curve, one sample for every `STEP_M` of the trail."""

    points_m: Array  # (n, 2) [arena]
    headings_rad: Array  # (n,), unwrapped
    stretch: Array  # (n,) metres of this lane for a metre of the trail
    turns: Array  # (n,) [rad for a metre of the trail]

    @classmethod
    def through(cls, points_m: Array) -> Self:
        """Return the curve through points, shape (n, 2), n >= 2, that belong to consecutive samples of the trail."""
        steps = np.gradient(points_m, STEP_M, axis=0)
        headings_rad = np.unwrap(np.arctan2(steps[:, 1], steps[:, 0]))
        return cls(points_m, headings_rad, np.hypot(steps[:, 0], steps[:, 1]), np.gradient(headings_rad, STEP_M))

    def normals(self) -> Array:
        """Return the unit vectors to the left, shape (n, 2)."""
        return np.stack([-np.sin(self.headings_rad), np.cos(self.headings_rad)], axis=1)

    def beside(self, lefts_m: Array) -> Lane:
        """Return the curve that lies `lefts_m`, shape (n,), to the left of this one."""
        return Lane.through(self.points_m + lefts_m[:, None] * self.normals())

    def at(self, arc_m: float, rate_m_s: float) -> Reference:
        """Return the reference at an arc length of the trail that grows by `rate_m_s`."""
        x, y = sample(self.points_m, arc_m)
        heading_rad, stretch, turn = (float(sample(row, arc_m)) for row in (self.headings_rad, self.stretch, self.turns))
        return Reference(Pose2(float(x), float(y), wrap_angle(heading_rad)), rate_m_s * stretch, rate_m_s * turn)

    @property
    def length_m(self) -> float:
        """The arc length of the trail at the last sample."""
        return (len(self.points_m) - 1) * STEP_M


def sample(rows: Array, arc_m: ArrayLike) -> Array:
    """Return rows, shape (n, ...), interpolated at arc lengths, held at both ends."""
    position = np.clip(np.asarray(arc_m) / STEP_M, 0.0, len(rows) - 1.0)
    first = np.minimum(position.astype(int), len(rows) - 2)
    share = (position - first).reshape(position.shape + (1,) * (rows.ndim - 1))
    return np.asarray(rows[first] * (1.0 - share) + rows[first + 1] * share)


def resampled(points_m: Array, step_m: float) -> Array:
    """Return points evenly spaced by about `step_m` along a polyline, both ends kept."""
    lengths_m = np.hypot(*np.diff(points_m, axis=0).T)
    arcs_m = np.concatenate([[0.0], np.cumsum(lengths_m)])
    count = max(round(float(arcs_m[-1]) / step_m), 1) + 1
    wanted = np.linspace(0.0, arcs_m[-1], count)
    return np.stack([np.interp(wanted, arcs_m, points_m[:, axis]) for axis in (0, 1)], axis=1)
