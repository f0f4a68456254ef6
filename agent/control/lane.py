"""The way that the reference has taken: a robot that has fallen behind follows it, and does not cut corners that things may stand in."""

from __future__ import annotations

import math

import numpy as np

from agent.control.tracking import Reference, caught_up_m_s
from agent.control.twist import Twist
from protocol.geometry import Pose2, wrap_angle

SPACING_M = 0.01  # between two places that are remembered
LONGEST = 60  # places
NEAR_M = 0.05  # a reference so near is followed itself
JUMP_M, FASTEST_M_S = 0.03, 0.3  # a reference that has moved by more than this, and faster, has not driven there
UPHILL_M = 0.02  # farther from the robot than the nearest place so far: before that the way was another one
BEND_M = 0.04  # over which a bend is measured
MOST_TURN_RAD_S = 1.2  # in a bend


class Lane:
    """Remembers the last places of one robot's references."""

    def __init__(self) -> None:
        self._places_m = np.empty((0, 2))  # [arena]
        self._stamp_ns = 0  # of the last reference

    def note(self, stamp_ns: int, arena_from_body: Pose2) -> None:
        """Take where the robot should be at a stamp."""
        place_m = arena_from_body[:2]
        most_m = JUMP_M + FASTEST_M_S * 1e-9 * max(stamp_ns - self._stamp_ns, 0)
        if not len(self._places_m) or math.dist(place_m, self._places_m[-1]) > most_m:
            self._places_m = np.array([place_m])
        way_m = place_m - self._places_m[-1]
        length_m = max(float(np.hypot(*way_m)), 1e-9)
        steps = np.arange(1, int(length_m / SPACING_M) + 1)
        self._places_m = np.vstack([self._places_m, self._places_m[-1] + steps[:, None] * SPACING_M / length_m * way_m])[-LONGEST:]
        self._stamp_ns = stamp_ns

    def reference(self, reference: Reference, arena_from_body: Pose2) -> Reference:
        """Return what to follow from where the robot is: the reference, or, far behind it, the way that it took, as fast as to catch up."""
        if math.dist(reference.arena_from_body[:2], arena_from_body[:2]) <= NEAR_M or reference.twist.speed_m_s < 0.0:
            return reference
        here = self._nearest(arena_from_body)
        left = len(self._places_m) - 1 - here
        if left * SPACING_M < BEND_M:
            return reference
        heading_rad, then_rad = self._heading_rad(here), self._heading_rad(here + round(BEND_M / SPACING_M))
        bend = wrap_angle(then_rad - heading_rad) / BEND_M
        speed_m_s = min(reference.twist.speed_m_s + caught_up_m_s(left * SPACING_M), MOST_TURN_RAD_S / max(abs(bend), 1e-6))
        x_m, y_m = self._places_m[here].tolist()
        return Reference(Pose2(x_m, y_m, heading_rad), Twist(speed_m_s, bend * speed_m_s))

    def _nearest(self, arena_from_body: Pose2) -> int:
        """Return the number of the place nearest to the robot on the last stretch of the way that led towards it."""
        off_m = np.hypot(*(self._places_m - arena_from_body[:2]).T)[::-1]
        uphill = off_m > np.minimum.accumulate(off_m) + UPHILL_M
        stretch_m = off_m[: int(np.argmax(uphill))] if uphill.any() else off_m
        return len(off_m) - 1 - int(np.argmin(stretch_m))

    def _heading_rad(self, number: int) -> float:
        """Return the direction of the way at a place."""
        first, last = self._places_m[max(number - 1, 0)], self._places_m[min(number + 2, len(self._places_m) - 1)]
        return math.atan2(last[1] - first[1], last[0] - first[0])
