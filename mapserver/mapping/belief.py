"""Where one robot is believed to be, and how that belief ages while the robot is silent."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from protocol.geometry import Array, Pose2, compose_covariance

EXTRAPOLATION_HORIZON_S = 1.0  # the wheel guard stops a robot without a fresh setpoint sooner than this
SILENT_MOTION_SIGMA_PER_S = np.array([0.1, 0.1, 0.3])  # a silent robot may do something else than its last motion [m/s, m/s, rad/s; body]


VAGUE = np.diag([1.0, 1.0, 0.25])  # of a robot that was just found: what found it is tied as well, and tells the rest [m, m, rad]


class Belief(NamedTuple):
    """A pose and its covariance, shape (3, 3), in the body frame [m, m, rad]; `predicted`: no measurement at this stamp."""

    arena_from_body: Pose2
    covariance: Array
    predicted: bool = False

    def moved(self, body_from_next: Pose2, covariance: Array) -> Belief:
        """Return the belief after an independent motion with its covariance, shape (3, 3), in the frame after the motion."""
        grown = compose_covariance(self.covariance, body_from_next, covariance)
        return Belief(self.arena_from_body @ body_from_next, grown, self.predicted)

    def covariance_of_point(self, point_body_m: Array) -> Array:
        """Return the covariance, shape (2, 2) [m^2; arena], of a point, shape (2,), fixed in the body frame."""
        x, y = point_body_m
        jacobian = self.arena_from_body.rotation() @ np.array([[1.0, 0.0, -y], [0.0, 1.0, x]])
        return np.asarray(jacobian @ self.covariance @ jacobian.T)

    def position_covariance(self) -> Array:
        """Return the covariance of the position, shape (2, 2) [m^2; arena]."""
        return self.covariance_of_point(np.zeros(2))


class Twist(NamedTuple):
    """A motion with the time it took: what a robot is expected to go on doing."""

    body_from_next: Pose2
    covariance: Array
    duration_s: float


def extrapolate(belief: Belief, last: Twist, elapsed_s: float) -> Belief:
    """Carry a belief forward by constant velocity, for at most `EXTRAPOLATION_HORIZON_S`; its covariance grows without end."""
    if elapsed_s <= 0.0:
        return belief
    share = min(elapsed_s, EXTRAPOLATION_HORIZON_S) / last.duration_s
    step = Pose2.exp(last.body_from_next.log() * share)
    growth = last.covariance * (elapsed_s / last.duration_s) + np.diag((SILENT_MOTION_SIGMA_PER_S * elapsed_s) ** 2)
    return belief.moved(step, growth)._replace(predicted=True)
