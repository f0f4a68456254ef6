"""The local guard: slows and stops the robot before anything that stands near it.

The body is a disc, so turning on the spot is always free, and a way is free as far as the disc, carried along its arc, keeps its margin.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from agent.control.borders import Borders
from agent.control.twist import Twist
from protocol.geometry import Array

SLOW_M = 0.12  # with less free way than this the robot is slower than it may be
MOVING_EXTRA_M = 0.03  # the margin from what moves by itself is larger by this
STEP_M = 0.005  # between two places of the disc that are looked at
NEARER_M = 0.002  # coming nearer by less than this is no approach ...
LEAST_M = 0.012  # ... except to what is nearer than this, or soon would be: many small approaches add up to a touch
CREEP_M_S = 0.04  # a robot that goes no faster keeps only that from what stands: it would stop at once
PACES = 1.0 - np.linspace(0.0, 1.0, 13)[:-1]  # of the wanted speed, that are tried in turn


@dataclass(frozen=True)
class Keeping:
    """How far the body, a disc, keeps from things."""

    radius_m: float
    margin_m: float = 0.02
    max_speed_m_s: float = 0.25  # with all the way free


@dataclass(frozen=True)
class Checked:
    """What is left of a wanted twist."""

    twist: Twist
    slowed: bool
    blocked: bool  # the robot would go, and cannot


def checked(wanted: Twist, things: Borders, keeping: Keeping) -> Checked:
    """Return the fastest twist with the wanted turn rate, and at most the wanted speed, whose own arc is free for long enough.

    With a free way s the speed is at most max_speed * s / SLOW_M, which is zero at the margin.
    """
    if wanted.speed_m_s == 0.0:
        return Checked(wanted, slowed=False, blocked=False)
    reach = SLOW_M + keeping.radius_m + keeping.margin_m + MOVING_EXTRA_M
    near = np.abs(things.points_m).max(axis=1) < reach
    things = Borders(things.points_m[near], things.moving[near])
    for pace in PACES:
        twist = Twist(float(pace) * wanted.speed_m_s, wanted.turn_rad_s)
        if abs(twist.speed_m_s) <= keeping.max_speed_m_s * free_way_m(twist, things, keeping) / SLOW_M:
            return Checked(twist, slowed=pace < 1.0, blocked=False)
    return Checked(Twist(0.0, wanted.turn_rad_s), slowed=True, blocked=True)


def free_way_m(twist: Twist, things: Borders, keeping: Keeping) -> float:
    """Return how far, at most SLOW_M, the body can go along a twist's arc before it comes too near to something.

    Too near is nearer than the margin, or, for what is nearer already, nearer than it is now: so leaving it is free.
    """
    if not len(things.points_m):
        return SLOW_M
    ways = np.linspace(STEP_M, SLOW_M, round(SLOW_M / STEP_M))
    centres = _along_arc(twist, ways)
    margins = np.where(things.moving, keeping.margin_m + MOVING_EXTRA_M, _margin_m(twist, keeping))
    x_m, y_m = things.points_m.T
    now = np.hypot(x_m, y_m) - keeping.radius_m
    then = np.hypot(centres[:, :1] - x_m, centres[:, 1:] - y_m) - keeping.radius_m
    too_near = (then < np.minimum(margins, np.minimum(now, np.maximum(now - NEARER_M, LEAST_M)))).any(axis=1)
    return float(ways[int(np.argmax(too_near))] - STEP_M) if too_near.any() else SLOW_M


def _margin_m(twist: Twist, keeping: Keeping) -> float:
    """Return how far the body keeps from what stands, at a twist's speed."""
    return min(keeping.margin_m, LEAST_M) if abs(twist.speed_m_s) <= CREEP_M_S else keeping.margin_m


def _along_arc(twist: Twist, ways_m: Array) -> Array:
    """Return where the body's centre is, (n, 2) [body], after some ways (n,) along the arc of a twist."""
    turns = ways_m * twist.turn_rad_s / abs(twist.speed_m_s)
    ahead = np.sinc(turns / np.pi) * ways_m
    aside = 0.5 * turns * np.sinc(0.5 * turns / np.pi) ** 2 * ways_m  # (1 - cos) / turn, which would cancel for small turns
    return np.column_stack([math.copysign(1.0, twist.speed_m_s) * ahead, math.copysign(1.0, twist.speed_m_s) * aside])
