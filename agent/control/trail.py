"""The way that a robot came: it has just driven there, so floor is there, and the robot fits through."""

from __future__ import annotations

import math

from protocol.geometry import Pose2

SPACING_M = 0.02  # between two places that are remembered; whoever is as near to one as this is back there
LONGEST = 25  # places: half a metre
AHEAD_M = 0.06  # along the way back: near enough that the robot backs up to it and does not cut corners


class Trail:
    """Remembers the last places of one robot, without the detours from which it has come back."""

    def __init__(self) -> None:
        self._places: list[Pose2] = []

    def note(self, odom_from_body: Pose2) -> None:
        """Take where the robot is now."""
        first = next((row for row, place in enumerate(self._places) if _apart_m(place, odom_from_body) < SPACING_M), None)
        if first is None:
            self._places = [*self._places, odom_from_body][-LONGEST:]
        else:
            self._places = self._places[: first + 1]

    def back(self, odom_from_body: Pose2) -> Pose2:
        """Return the place [odom] a little back along the way, the first that is remembered where there is none; here before any."""
        here, way_m = odom_from_body, 0.0
        for place in reversed(self._places):
            way_m += _apart_m(here, place)
            here = place
            if way_m >= AHEAD_M:
                break
        return here


def _apart_m(one: Pose2, other: Pose2) -> float:
    return math.dist(one[:2], other[:2])
