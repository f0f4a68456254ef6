"""A robot's path from the speeds of its base alone, and what that path is worth. Pure."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from protocol.geometry import Array, Pose2

MAX_HOLD_S = 1.5  # a speed that is not said again for so long holds no longer
KEPT_S = 10.0  # how long ago a pose may be asked for
LEAST_SIGMA = np.array([5e-4, 5e-4, 5e-4])  # of a motion, also of one that stood [m, m, rad]


@dataclass(frozen=True)
class MotionNoise:
    """What dead reckoning errs by: shares of what was driven and turned, and random walks while the base moves.

    A base on two wheels cannot slip sideways, so what is lost sideways is a small share of what was driven.
    """

    forward_share: float
    side_share: float
    turn_share: float
    walk_m_sqrt_s: float  # along the body's x axis [m / sqrt(s)]
    walk_rad_sqrt_s: float  # [rad / sqrt(s)]


class Odometer(NamedTuple):
    """Where the base has got to, and how."""

    odom_from_body: Pose2
    driven_m: float
    turned_rad: float
    moving_s: float

    def after(self, forward_m_s: float, turn_rad_s: float, elapsed_s: float) -> Odometer:
        """Return the odometer after these speeds have held for a while."""
        forward_m, turn_rad = forward_m_s * elapsed_s, turn_rad_s * elapsed_s
        if forward_m == 0.0 and turn_rad == 0.0:
            return self
        return Odometer(
            self.odom_from_body @ Pose2.exp((forward_m, 0.0, turn_rad)),
            self.driven_m + abs(forward_m),
            self.turned_rad + abs(turn_rad),
            self.moving_s + elapsed_s,
        )


class _Leg(NamedTuple):
    """From a stamp on, these speeds hold until the next leg."""

    stamp_ns: int
    odometer: Odometer
    forward_m_s: float
    turn_rad_s: float

    def at(self, stamp_ns: int) -> Odometer:
        elapsed_s = min(max((stamp_ns - self.stamp_ns) * 1e-9, 0.0), MAX_HOLD_S)
        return self.odometer.after(self.forward_m_s, self.turn_rad_s, elapsed_s)


class DeadReckoning:
    """Integrates speeds as they come; asked for the odometer at any stamp of the last seconds."""

    def __init__(self, response_s: float) -> None:
        """`response_s`: how long after its stamp a speed begins to hold, since a commanded base has to get there first."""
        self._response_ns = round(response_s * 1e9)
        self._legs: list[_Leg] = []

    def add(self, stamp_ns: int, forward_m_s: float, turn_rad_s: float) -> None:
        """Take the base's speeds from a stamp on, which is no older than the last one."""
        begins_ns = stamp_ns + self._response_ns
        begun = self._legs[-1].at(begins_ns) if self._legs else Odometer(Pose2.identity(), 0.0, 0.0, 0.0)
        self._legs.append(_Leg(begins_ns, begun, forward_m_s, turn_rad_s))

    def at(self, stamp_ns: int) -> Odometer:
        """Return the odometer at a stamp; before the first speed the base stood."""
        if not self._legs:
            return Odometer(Pose2.identity(), 0.0, 0.0, 0.0)
        number = bisect_right(self._legs, stamp_ns, key=lambda leg: leg.stamp_ns)
        return self._legs[max(number - 1, 0)].at(stamp_ns)

    def forget_before(self, stamp_ns: int) -> None:
        """Drop what is older than anybody asks for."""
        number = bisect_right(self._legs, stamp_ns - round(KEPT_S * 1e9), key=lambda leg: leg.stamp_ns)
        del self._legs[: max(number - 1, 0)]


def motion_covariance(before: Odometer, after: Odometer, noise: MotionNoise) -> Array:
    """Return the covariance of a motion, shape (3, 3) [m, m, rad; body after it], as independent of all other motions."""
    driven_m, turned_rad, moving_s = (now - then for now, then in zip(after[1:], before[1:], strict=True))
    forward = (noise.forward_share * driven_m) ** 2 + noise.walk_m_sqrt_s**2 * moving_s
    side = (noise.side_share * driven_m) ** 2
    turn = (noise.turn_share * turned_rad) ** 2 + noise.walk_rad_sqrt_s**2 * moving_s
    return np.diag(np.array([forward, side, turn]) + LEAST_SIGMA**2)
