"""How fast a Create 2's wheels are told to run over the floor by each of its drive commands ("Actuator Commands")."""

from __future__ import annotations

from sim.firmware import create2_tables as oi
from sim.world.drive import Wheels


def direct(right_mm_s: int, left_mm_s: int) -> Wheels:
    """Opcode 145."""
    return _possible(left_mm_s, right_mm_s)


def pwm(right: int, left: int) -> Wheels:
    """Opcode 146: a wheel at full duty runs as fast as it can."""
    mm_s = oi.FASTEST_MM_S / oi.FULL_PWM
    return _possible(left * mm_s, right * mm_s)


def about_radius(speed_mm_s: int, radius_mm: int, wheel_base_m: float) -> Wheels:
    """Opcode 137: the middle between the wheels runs at a speed about a point at a radius to its left."""
    speed = min(max(speed_mm_s, -oi.FASTEST_MM_S), oi.FASTEST_MM_S)
    if radius_mm in oi.ON_THE_SPOT:
        turn = speed * oi.ON_THE_SPOT[radius_mm]
        return Wheels(-turn, turn)
    if radius_mm in oi.STRAIGHT or radius_mm == 0:
        return Wheels(speed, speed)
    bend = 500.0 * wheel_base_m / min(max(radius_mm, -oi.WIDEST_MM), oi.WIDEST_MM)
    return _possible(speed * (1.0 - bend), speed * (1.0 + bend))


def brings_cliff_nearer(rims_mm_s: Wheels, wheel_base_m: float) -> bool:
    """Tell whether Safe mode heeds cliffs: going forward, or backward about a point within the robot ("Safe Mode")."""
    forward, turn = rims_mm_s.left + rims_mm_s.right, abs(rims_mm_s.right - rims_mm_s.left)
    return forward > 0.0 or 0.5 * wheel_base_m * abs(forward) < oi.ROBOT_RADIUS_M * turn


def _possible(left_mm_s: float, right_mm_s: float) -> Wheels:
    left, right = (min(max(speed, -oi.FASTEST_MM_S), oi.FASTEST_MM_S) for speed in (left_mm_s, right_mm_s))
    return Wheels(left, right)
