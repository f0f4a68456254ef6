"""The differential drive: two driven wheels with lagging motors, slipping tyres and counting encoders.

The paper's Eq. 1, for wheels a base L apart whose rims run at v_l and v_r over the floor: v = (v_r + v_l) / 2, omega = (v_r - v_l) / L.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from protocol.geometry import Pose2

FASTEST_RAD_S = 20.0  # of any wheel: what the motors give at most


class Wheels(NamedTuple):
    """One value for each wheel: speeds [rad/s], angles [rad], or lengths [m]."""

    left: float
    right: float


STILL = Wheels(0.0, 0.0)
FULL_GRIP = Wheels(1.0, 1.0)


@dataclass(frozen=True)
class Drive:
    """How a robot's drive truly is."""

    wheel_base_m: float
    radii_m: Wheels
    encoder_ticks_per_rev: int
    motor_lag_s: float  # time constant with which a wheel's speed follows its command; 0: at once
    slip_m_per_sqrt_m: float  # one sigma of what a wheel slips over one metre; it grows with the root of the way


class Turning(NamedTuple):
    """How the wheels turn at one moment."""

    speeds_rad_s: Wheels
    angles_rad: Wheels  # cumulative


def turned(drive: Drive, turning: Turning, command_rad_s: Wheels, duration_s: float) -> Turning:
    """Return how the wheels turn after a while under one command, which motors follow with a first-order lag, in closed form."""
    left, right = (
        _turned(speed, min(max(command, -FASTEST_RAD_S), FASTEST_RAD_S), drive.motor_lag_s, duration_s)
        for speed, command in zip(turning.speeds_rad_s, command_rad_s, strict=True)
    )
    angles = turning.angles_rad
    return Turning(Wheels(left[0], right[0]), Wheels(angles.left + left[1], angles.right + right[1]))


def rolled_m(drive: Drive, angles_rad: Wheels, grip: Wheels, noise: Wheels) -> Wheels:
    """Return the way that each rim makes over the floor while its wheel turns by an angle.

    `grip` is the part of the turning that moves the robot; `noise` is drawn from a normal distribution of sigma 1.
    """
    left, right = (
        radius * angle * held + drive.slip_m_per_sqrt_m * math.sqrt(abs(radius * angle)) * random
        for radius, angle, held, random in zip(drive.radii_m, angles_rad, grip, noise, strict=True)
    )
    return Wheels(left, right)


def moved(drive: Drive, arena_from_body: Pose2, way_m: Wheels) -> Pose2:
    """Return the pose after both rims have made their way, which is an exact arc (the paper's Eq. 1, integrated)."""
    forward_m = 0.5 * (way_m.right + way_m.left)
    turn_rad = (way_m.right - way_m.left) / drive.wheel_base_m
    return arena_from_body @ Pose2.exp((forward_m, 0.0, turn_rad))


def encoder_angles_rad(drive: Drive, angles_rad: Wheels) -> Wheels:
    """Return what the encoders tell: whole ticks."""
    tick_rad = 2.0 * math.pi / drive.encoder_ticks_per_rev
    return Wheels(math.floor(angles_rad.left / tick_rad) * tick_rad, math.floor(angles_rad.right / tick_rad) * tick_rad)


def _turned(speed: float, command: float, lag_s: float, duration_s: float) -> tuple[float, float]:
    """Return one wheel's speed after a while, and the angle it has turned by then."""
    decayed = math.exp(-duration_s / lag_s) if lag_s > 0.0 else 0.0
    return command + (speed - command) * decayed, command * duration_s + (speed - command) * lag_s * (1.0 - decayed)
