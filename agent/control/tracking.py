"""From where the robot should be to how it should move: the tracking law of a unicycle.

Near a reference that moves: Kanayama et al., "A stable tracking control method for an autonomous mobile robot", ICRA 1990, in the
form of Samson, "Control of chained systems: application to path following and time-varying point-stabilization of mobile robots", IEEE
T-AC 40(1), 1995. Such laws cannot come up to a reference that stands beside the robot; there, and far
from any reference, the robot turns towards it first and then drives up to it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from agent.control.twist import STANDING, Twist
from protocol.geometry import Pose2, wrap_angle

ALONG_PER_S = 1.8  # how fast an error along the way is made up for
ACROSS_M = 0.14  # an error to the side decays over so much way
HEADING_PER_S = 2.2  # damps the above up to full speed
CATCH_UP_M_S = 0.12  # by which the robot may be faster than its reference

FAR_M = 0.30  # from here on the robot makes for the reference itself, not for its way
STANDS_M_S, STANDS_RAD_S = 0.01, 0.03  # a reference slower than this stands
CREEPS_M_S = 0.03  # slower than this it steers the less for an error to the side, since there is hardly any way to make it up on
APPROACH_M_S = 0.20
TURN_FIRST_RAD = 0.6  # a target further to the side is turned to on the spot
TURN_RAD_S = 1.8
REVERSE_M, REVERSE_M_S = 0.10, 0.08  # a target this near behind the robot is backed up to, gently

ARRIVED_M = 0.015  # from here on the robot makes up only for what lies straight ahead or behind
DEAD_M, DEAD_RAD = 0.004, math.radians(1.0)  # what is left at rest


class Reference(NamedTuple):
    """Where the robot should be, and how it should be moving there."""

    arena_from_body: Pose2
    twist: Twist

    def later(self, duration_s: float) -> Reference:
        """Return the reference after some time in which it went on as it was."""
        return Reference(self.arena_from_body @ self.twist.motion(duration_s), self.twist)


def track(body_from_reference: Pose2, reference: Twist) -> Twist:
    """Return how to move, before any limit, given where the reference is as seen from the robot, and how it moves."""
    distance_m = math.hypot(body_from_reference.x_m, body_from_reference.y_m)
    if distance_m > FAR_M:
        return _approach(body_from_reference, reference.speed_m_s)
    if abs(reference.speed_m_s) > STANDS_M_S or abs(reference.turn_rad_s) > STANDS_RAD_S:
        return _follow(body_from_reference, reference)
    return _settle(body_from_reference) if distance_m < ARRIVED_M else _approach(body_from_reference, 0.0)


def caught_up_m_s(behind_m: float) -> float:
    """Return by how much faster than its reference a robot is to be that is so far behind it."""
    return _within(ALONG_PER_S * behind_m, CATCH_UP_M_S)


def _follow(error: Pose2, reference: Twist) -> Twist:
    """Return the twist that stays with a moving reference.

    Samson's law with its gain of the error to the side inverse to the speed: far aside the robot comes back across, and near at an angle
    that falls with the error, so that the path does not depend on the speed.
    """
    side = max(-1.0, min(1.0, reference.speed_m_s / CREEPS_M_S))
    aim_rad = wrap_angle(error.theta_rad + side * math.atan(error.y_m / ACROSS_M))
    speed = reference.speed_m_s * math.cos(error.theta_rad) + caught_up_m_s(error.x_m)
    return Twist(speed, reference.turn_rad_s + HEADING_PER_S * aim_rad)


def _approach(target: Pose2, speed_m_s: float) -> Twist:
    """Return the twist that makes for a target's place, whatever its heading; backwards to one that goes backwards."""
    distance_m = math.hypot(target.x_m, target.y_m)
    backs_up = target.x_m < 0.0 and distance_m < REVERSE_M
    direction = -1.0 if backs_up or speed_m_s < -STANDS_M_S else 1.0
    most_m_s = REVERSE_M_S if backs_up else APPROACH_M_S + abs(speed_m_s)
    bearing_rad = math.atan2(direction * target.y_m, direction * target.x_m)
    turn = _within(HEADING_PER_S * bearing_rad, TURN_RAD_S)
    if abs(bearing_rad) > TURN_FIRST_RAD:
        return Twist(0.0, turn)
    return Twist(direction * min(ALONG_PER_S * distance_m, most_m_s) * math.cos(bearing_rad), turn)


def _settle(target: Pose2) -> Twist:
    """Return the twist for the last millimetres and degrees to a target that stands, and none within the dead zone."""
    if abs(target.x_m) > DEAD_M:
        return Twist(ALONG_PER_S * target.x_m, 0.0)
    if abs(target.theta_rad) > DEAD_RAD:
        return Twist(0.0, _within(HEADING_PER_S * wrap_angle(target.theta_rad), TURN_RAD_S))
    return STANDING


def _within(value: float, most: float) -> float:
    return max(-most, min(most, value))
