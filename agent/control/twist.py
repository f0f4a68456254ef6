"""How a body with two driven wheels moves: forward speed and turn rate, and the wheels that make them (the paper's Eq. 1)."""

from __future__ import annotations

from typing import NamedTuple

from agent.slam.odometry import WheelGeometry
from protocol.geometry import Pose2


class Twist(NamedTuple):
    """Speed along the body's x axis [m/s] and turn rate, counter-clockwise [rad/s]."""

    speed_m_s: float
    turn_rad_s: float

    def scaled(self, factor: float) -> Twist:
        """Return the same arc at another pace."""
        return Twist(factor * self.speed_m_s, factor * self.turn_rad_s)

    def motion(self, duration_s: float) -> Pose2:
        """Return start_from_body after moving like this for some time: an arc of a circle."""
        return Pose2.exp((self.speed_m_s * duration_s, 0.0, self.turn_rad_s * duration_s))


STANDING = Twist(0.0, 0.0)


def wheel_speeds(twist: Twist, wheels: WheelGeometry) -> tuple[float, float]:
    """Return the speeds of the left and the right wheel [rad/s]: v = (v_r + v_l) / 2 and omega = (v_r - v_l) / L of Eq. 1, solved."""
    sideways_m_s = 0.5 * wheels.base_m * twist.turn_rad_s
    return (twist.speed_m_s - sideways_m_s) / wheels.radius_m, (twist.speed_m_s + sideways_m_s) / wheels.radius_m


def within_wheel_speed(left_rad_s: float, right_rad_s: float, max_wheel_rad_s: float) -> tuple[float, float]:
    """Return both wheel speeds slowed by one factor until neither exceeds the limit, so that the arc stays the same."""
    factor = min(1.0, max_wheel_rad_s / max(abs(left_rad_s), abs(right_rad_s), 1e-9))
    return factor * left_rad_s, factor * right_rad_s
