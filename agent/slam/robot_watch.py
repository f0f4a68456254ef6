"""Watches for other robots: follows those in view from frame to frame, and tries round bases that might be one.

Who a robot is, and whether it is one at all, only the map server can say, which knows where all robots are. Here a sighting is a place at
which the whole silhouette of a robot's body was found.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from agent.vision.floor_view import Picture
from agent.vision.robot_fit import RobotFit, RobotFitter
from protocol.geometry import Array, Pose2

TRIES_PER_FRAME = 2
PAUSE_FRAMES = 12  # a place where no robot was found is not tried again for so long
LOST_FRAMES = 10  # a robot that is not found again is looked for where it should be for so long: often only its silhouette was not clear
NEW_FRAMES, CHECK_FRAMES = 3, 5  # a robot is looked at from all its likely places in its first frames, and then in every fifth
CONVINCING_SUPPORT, CONVINCING_MISFIT_PX = 0.75, 0.35  # of a whole silhouette in plain sight; a ring above the base fits its sides worse
NEARER_M = 0.008  # a fit starts this much nearer than expected: more than a robot's place is wrong by, less than to its next edge
MOST_A_FRAME, SURE = 3.0, 6.0  # evidence that one picture may give, and that a robot gathers; without any it is none
RING_M = 0.03  # the painted ring above the base appears about this much farther out
SAME_PLACE_M = 0.06  # under a body's radius: what is tried again there would be the same thing
SAME_START_M = 0.003  # starts nearer to each other than this end in the same fit

Judge = Callable[[RobotFit], float]
Scan = Callable[[int], Array]


@dataclass(frozen=True, eq=False)
class _Known:
    place_m: Array  # (2,) [odom]
    velocity_m: Array  # (2,) per frame [odom]
    seen_m: Array  # (2,) [body at that frame]
    evidence: float  # that it is one
    frames: int = 1  # for how long it has been followed
    missed: int = 0  # for how many frames it was not found

    def expected_m(self) -> Array:
        """Return where it should be by the next frame, (2,) [odom]."""
        return self.place_m + self.velocity_m

    def is_due(self) -> bool:
        """Tell whether it is looked at thoroughly: in its first frames, and now and then."""
        return self.frames < NEW_FRAMES or self.frames % CHECK_FRAMES == 0


class _Sight(NamedTuple):
    """One picture, and what goes with it."""

    grey: Picture
    odom_from_body: Pose2
    judge: Judge  # tells what of a fit speaks for a robot


class _Refused:
    """Remembers where no robot was found, for a while."""

    def __init__(self) -> None:
        self._places: list[tuple[Array, int]] = []  # (2,) [odom], and the frame

    def add(self, place: Array, frame: int) -> None:
        self._places.append((place, frame))

    def holds(self, place: Array, frame: int) -> bool:
        self._places = [(other, then) for other, then in self._places if frame - then < PAUSE_FRAMES]
        return any(np.hypot(*(place - other)) < SAME_PLACE_M for other, _ in self._places)


class RobotWatch:
    """Remembers where robots were last found, and where none was."""

    def __init__(self, fitter: RobotFitter, radius_m: float, eye_m: Array) -> None:
        self._fitter = fitter
        self._radius_m = radius_m
        self._eye_m = eye_m  # (2,) the point under the camera [body]
        self._known: list[_Known] = []
        self._by_border, self._by_picture = _Refused(), _Refused()  # neither holds up the other
        self._frame = self._scanned = 0  # how many there were, and for how many of them the picture was scanned

    def refit(self, fitter: RobotFitter, eye_m: Array) -> None:
        """Go on with a camera that is known better."""
        self._fitter, self._eye_m = fitter, eye_m

    def expected_m(self, odom_from_body: Pose2) -> Array:
        """Return where the robots in view, and those lost just now, should be by now, (n, 2) [body]."""
        places_m = [known.expected_m() for known in self._known]
        return odom_from_body.inverse().apply(np.array(places_m).reshape(-1, 2))

    def look(self, grey: Picture, odom_from_body: Pose2, bases: Array, scan: Scan, judge: Judge) -> list[RobotFit]:
        """Return all robots found in a grey camera picture; what might be one is told as range and bearing from the camera, (n, 2).

        `bases` are told by the border of what is no floor. `scan` looks for more in the picture itself, elsewhere in every turn: one for
        each frame, but only when there is time to try what it tells. `judge` tells what of a fit speaks for a robot, -inf where floor shows
        through it.
        """
        self._frame += 1
        sight = _Sight(grey, odom_from_body, judge)
        found = self._follow(sight)
        if tries := self._tries():
            self._try_some(sight, bases, tries, self._by_border, found)
            likely = np.concatenate([scan(turn) for turn in range(self._scanned, self._frame)])
            self._try_some(sight, likely, tries, self._by_picture, found)
            self._scanned = self._frame
        return found

    def _try_some(self, sight: _Sight, bases: Array, tries: int, refused: _Refused, found: list[RobotFit]) -> None:
        """Try as many of `bases`, (n, 2), as there are tries, and add the robots that are there to `found`."""
        for range_m, bearing_rad in bases:
            centre = self._eye_m + range_m * np.array([np.cos(bearing_rad), np.sin(bearing_rad)])
            place = sight.odom_from_body.apply(centre)
            if not tries:
                return
            if self._taken(centre, found) or refused.holds(place, self._frame):
                continue
            tries -= 1
            fit = self._try(sight.grey, float(range_m), float(bearing_rad))
            evidence = _weighed(fit, sight.judge)
            if fit is None or evidence <= 0.0 or self._taken(fit.centre_m, found):
                refused.add(place, self._frame)
            else:
                found.append(fit)
                self._known.append(_Known(sight.odom_from_body.apply(fit.centre_m), np.zeros(2), fit.centre_m, evidence))

    def _tries(self) -> int:
        """Return how many new places may be tried in this frame: some while nobody is in view, then one in every other frame."""
        return (self._frame % 2) if any(not known.missed for known in self._known) else TRIES_PER_FRAME

    def _follow(self, sight: _Sight) -> list[RobotFit]:
        """Find again the robots of the last frames; those not found for long are given up, and those that turn out to be none."""
        grey, odom_from_body, judge = sight
        body_from_odom = odom_from_body.inverse()
        found: list[RobotFit] = []
        known: list[_Known] = []
        for last in self._known:
            starts = [last.expected_m(), odom_from_body.apply(last.seen_m), last.place_m]
            fit = self._best(grey, [body_from_odom.apply(start) for start in starts], thorough=last.is_due() and not last.missed)
            weight = _weighed(fit, judge)
            if fit is None or weight == -math.inf:
                if last.missed < LOST_FRAMES - 1:
                    known.append(replace(last, place_m=last.expected_m(), missed=last.missed + 1))
            elif not self._taken(fit.centre_m, found):
                place, evidence = odom_from_body.apply(fit.centre_m), min(last.evidence + weight, SURE)
                if evidence > 0.0:
                    found.append(fit)
                    known.append(_Known(place, place - last.place_m, fit.centre_m, evidence, last.frames + 1))
                else:
                    self._refuse(place)
        self._known = known
        return found

    def _refuse(self, place: Array) -> None:
        """Let a place, (2,) [odom], rest, where what was followed turned out to be no robot."""
        for refused in (self._by_border, self._by_picture):
            refused.add(place, self._frame)

    def _best(self, grey: Picture, starts_m: list[Array], *, thorough: bool) -> RobotFit | None:
        """Return the first convincing fit, else that whose sides fit best: a robot goes on as before, moves along with us, or has stopped.

        Every start is taken a little too near, since from there the base is the first edge to be met. A ring above the base looks like a
        base farther out, so what does not convince is tried once more from well before it. Unless `thorough`, the first fit will do.
        """
        best: RobotFit | None = None
        for start in _apart(starts_m):
            best = _better(best, self._fitter.fit(grey, start + _towards(start, self._eye_m, NEARER_M)))
            if best is not None and (_convinces(best) or not thorough):
                return best
        if best is None:
            return None
        return _better(best, self._fitter.fit(grey, best.centre_m + _towards(best.centre_m, self._eye_m, RING_M)))

    def _taken(self, centre_m: Array, found: list[RobotFit]) -> bool:
        return any(np.hypot(*(centre_m - other.centre_m)) < self._radius_m for other in found)

    def _try(self, grey: Picture, range_m: float, bearing_rad: float) -> RobotFit | None:
        start = self._fitter.search(grey, range_m - self._radius_m, bearing_rad)
        return None if start is None else self._fitter.fit(grey, start)


def _weighed(fit: RobotFit | None, judge: Judge) -> float:
    """Return what one picture adds to the evidence for a robot; -inf where none was fitted, or floor shows through it."""
    weight = -math.inf if fit is None else judge(fit)
    return weight if weight == -math.inf else min(max(weight, -MOST_A_FRAME), MOST_A_FRAME)


def _apart(starts_m: list[Array]) -> list[Array]:
    """Return the starts without those that begin where an earlier one did."""
    kept: list[Array] = []
    for start in starts_m:
        if all(np.hypot(*(start - other)) > SAME_START_M for other in kept):
            kept.append(start)
    return kept


def _towards(point: Array, target: Array, length_m: float) -> Array:
    """Return the step of a given length from one point, (2,) [m], towards another."""
    way = target - point
    return np.asarray(way * (length_m / max(float(np.hypot(*way)), 1e-9)))


def _convinces(fit: RobotFit) -> bool:
    return fit.misfit_px < CONVINCING_MISFIT_PX and fit.support > CONVINCING_SUPPORT


def _better(first: RobotFit | None, second: RobotFit | None) -> RobotFit | None:
    """Return the fit whose sides lie closer to their edges."""
    if first is None or second is None:
        return first or second
    return second if second.misfit_px < first.misfit_px else first
