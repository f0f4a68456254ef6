"""What the wheels say between two pictures, and what that would be with a rig that is a little different."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from agent.slam.odometry import WheelGeometry, WheelNoise, arc_motion
from agent.slam.rig_parameters import BASE, LAG, LEFT, PARAMETERS, RIGHT, changed_wheels
from agent.wheel_history import WheelState
from protocol.geometry import Array, Pose2

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

    def motion(self, change: Array) -> Pose2:
        """Return the motion with the wheels changed by (PARAMETERS,)."""
        turned = self.turned_rad.copy()
        turned[0] -= change[LAG] * self.first.speeds_rad_s
        turned[-1] += change[LAG] * self.last.speeds_rad_s
        wheels = changed_wheels(self.wheels, change)
        motion = Pose2.identity()
        for angles in turned:
            motion = motion @ arc_motion(angles, wheels)
        return motion

    def sensitivity(self, change: Array) -> Array:
        """Return d motion [m, m, rad; its end] / d parameter, shape (3, PARAMETERS)."""
        columns = np.zeros((3, PARAMETERS))
        here = self.motion(change)
        for number in (LEFT, RIGHT, BASE, LAG):
            step = np.zeros(PARAMETERS)
            step[number] = STEP
            columns[:, number] = (here.between(self.motion(change + step)).log() - here.between(self.motion(change - step)).log()) / (
                2.0 * STEP
            )
        return columns

    def information(self, noise: WheelNoise) -> Array:
        """Return the inverse covariance, (3, 3), of slipping alone: scale errors are what is looked for."""
        way_m = float(np.abs(self.turned_rad).sum()) * 0.5 * self.wheels.radius_m
        slip_m2 = noise.slip_m_per_sqrt_m**2 * way_m
        along, turn = 0.5 * slip_m2 + SLIP_M**2, 2.0 * slip_m2 / self.wheels.base_m**2 + SLIP_RAD**2
        return np.diag([1.0 / along, 1.0 / (0.25 * slip_m2 + SLIP_M**2), 1.0 / turn])
