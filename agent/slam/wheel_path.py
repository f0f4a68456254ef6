"""What the wheels say between two pictures, and what that would be with a rig that is a little different."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from agent.slam.odometry import WheelGeometry, WheelNoise
from agent.slam.rig_parameters import BASE, LAG, LEFT, PARAMETERS, RIGHT
from agent.wheel_history import WheelState
from protocol.geometry import Array, Pose2, wrap_angle

CHANGED = [LEFT, RIGHT, BASE, LAG]  # what of a rig the path depends on
STEP = 1e-3  # of a parameter, for differences
SLIP_M, SLIP_RAD = 2e-4, 2e-3  # that wheels err by at least


@dataclass(frozen=True, eq=False)
class WheelPath:
    """What the wheels said between two pictures."""

    turned_rad: Array  # (k, 2) left, right, from picture to picture
    first: WheelState
    last: WheelState
    wheels: WheelGeometry

    @classmethod
    def through(cls, states: Sequence[WheelState], wheels: WheelGeometry) -> WheelPath:
        """Return the path through two or more states of the wheels."""
        angles_rad = np.array([state.angles_rad for state in states])
        return cls(np.diff(angles_rad, axis=0), states[0], states[-1], wheels)

    def motion(self, change: Array) -> tuple[Pose2, Array]:
        """Return the motion with the wheels changed by (PARAMETERS,), and d motion [m, m, rad; its end] / d parameter, (3, PARAMETERS)."""
        steps = STEP * np.eye(PARAMETERS)[CHANGED]
        ends = self._ends(change + np.concatenate([np.zeros((1, PARAMETERS)), steps, -steps]))
        x_m, y_m, theta_rad = ends[0].tolist()
        motion = Pose2(x_m, y_m, wrap_angle(theta_rad))
        more, less = np.split(ends[1:], 2)
        sensitivity = np.zeros((3, PARAMETERS))
        sensitivity[:, CHANGED] = ((more - less) / (2.0 * STEP)).T
        sensitivity[:2] = motion.rotation().T @ sensitivity[:2]
        return motion, sensitivity

    def _ends(self, changes: Array) -> Array:
        """Return where the path ends, (n, 3) [m, m, rad; its beginning], with the wheels changed by (n, PARAMETERS): a chain of arcs."""
        turned = np.repeat(self.turned_rad[None], len(changes), axis=0)  # (n, k, 2)
        turned[:, 0] -= changes[:, LAG, None] * self.first.speeds_rad_s
        turned[:, -1] += changes[:, LAG, None] * self.last.speeds_rad_s
        radii_m = self.wheels.radius_m * np.array(self.wheels.scale) * np.exp(changes[:, [LEFT, RIGHT]])
        left_m, right_m = np.moveaxis(turned * radii_m[:, None], -1, 0)
        turns_rad = (right_m - left_m) / (self.wheels.base_m * np.exp(changes[:, BASE, None]))
        headings_rad = np.cumsum(turns_rad, axis=1)
        chords_m = 0.5 * (left_m + right_m) * np.sinc(turns_rad / (2.0 * np.pi))
        towards_rad = headings_rad - 0.5 * turns_rad
        return np.column_stack(
            [(chords_m * np.cos(towards_rad)).sum(axis=1), (chords_m * np.sin(towards_rad)).sum(axis=1), headings_rad[:, -1]]
        )

    def information(self, noise: WheelNoise) -> Array:
        """Return the inverse covariance, (3, 3), of slipping alone: scale errors are what is looked for."""
        way_m = float(np.abs(self.turned_rad).sum()) * 0.5 * self.wheels.radius_m
        slip_m2 = noise.slip_m_per_sqrt_m**2 * way_m
        along, turn = 0.5 * slip_m2 + SLIP_M**2, 2.0 * slip_m2 / self.wheels.base_m**2 + SLIP_RAD**2
        return np.diag([1.0 / along, 1.0 / (0.25 * slip_m2 + SLIP_M**2), 1.0 / turn])
