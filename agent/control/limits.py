"""What a robot may do: limits of speed, turn rate, wheel speed and acceleration. Too fast an arc is driven more slowly, not another arc."""

from __future__ import annotations

from dataclasses import dataclass

from agent.control.twist import STANDING, Twist


@dataclass(frozen=True)
class DriveLimits:
    """The limits of one robot; each holds in both directions."""

    max_speed_m_s: float = 0.25
    max_turn_rad_s: float = 2.5
    max_wheel_rad_s: float = 12.0
    max_acceleration_m_s2: float = 0.6  # speeding up; a robot slows down twice as hard
    max_turn_acceleration_rad_s2: float = 12.0


BRAKING = 2.0  # times the acceleration


def within_speeds(wanted: Twist, limits: DriveLimits) -> Twist:
    """Return the same arc at a pace within the limits of speed and turn rate."""
    too_fast = max(abs(wanted.speed_m_s) / limits.max_speed_m_s, abs(wanted.turn_rad_s) / limits.max_turn_rad_s)
    return wanted.scaled(1.0 / too_fast) if too_fast > 1.0 else wanted


def within_accelerations(wanted: Twist, last: Twist, elapsed_s: float, limits: DriveLimits) -> Twist:
    """Return the twist nearest to the wanted one, each part by itself, that can be reached in some time after the last one."""
    return Twist(
        _reachable(wanted.speed_m_s, last.speed_m_s, limits.max_acceleration_m_s2 * elapsed_s),
        _reachable(wanted.turn_rad_s, last.turn_rad_s, limits.max_turn_acceleration_rad_s2 * elapsed_s),
    )


def applied(wanted: Twist, last: Twist, elapsed_s: float, limits: DriveLimits) -> Twist:
    """Return what is driven of a wanted twist; to stand is always allowed at once."""
    if wanted == STANDING:
        return STANDING
    return within_accelerations(within_speeds(wanted, limits), last, elapsed_s, limits)


def _reachable(wanted: float, last: float, step: float) -> float:
    """Return the value nearest to the wanted one that differs from the last by at most a step away from zero, or more towards it."""
    side = -1.0 if last < 0.0 else 1.0
    reached = max(abs(last) - BRAKING * step, min(abs(last) + step, side * wanted))
    return side * max(reached, -step)  # past zero it is speeding up again
