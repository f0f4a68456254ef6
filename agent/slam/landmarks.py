"""The robot's own map of the floor: keyframes of the places where it was, by which it knows how far it has drifted when it comes back.

A place is entered once, and stays where it was believed to be then. Who recognises it is where it was left, as surely as that was known,
however long the way since: so error grows with the way to a place the first time, and no further. The agent's `odom` frame takes no
part: it never jumps, and what is recognised goes into the pose graph.

A robot that was lifted may be anywhere. It is looked for in all places, and until it is found no new one is entered.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from agent.slam.ego_motion import Motion
from agent.slam.floor_motion import Alignment, Glance, Keyframe
from agent.slam.place_finder import Marks, find, marks_of
from agent.slam.recognition import is_findable, recognise
from agent.vision.floor_patch import FloorPatch
from protocol.geometry import Array, Pose2, compose_covariance

MOST_LANDMARKS = 200  # about 0.2 MB each
RANGE_IN_REACHES = 0.27  # of the patch: landmarks this near are looked for
SPACING_IN_REACHES = 0.2  # between landmarks at least
AWAY_KEYFRAMES = 3  # begun since a landmark was last seen: before that it can hardly tell of any drift
PAUSE_FRAMES = 3  # between two looks, which take a millisecond or two each
MOST_FAILURES = 4  # in a row: the floor there, or its light, has changed
SEARCHED_A_FRAME = 4  # landmarks, each of which takes two milliseconds, by a robot that was lifted
ANYWHERE = np.diag([1e4, 1e4, 10.0])  # where a robot is that was lifted [m, m, rad]


@dataclass(eq=False)
class Landmark:
    """A keyframe, and where the body was when it was taken."""

    stamp_ns: int
    keyframe: Keyframe
    marks: Marks
    map_from_body: Pose2
    covariance: Array  # (3, 3) [m, m, rad; body] of where it was, as seen from the first
    seen: int  # how many keyframes had been begun when it was last seen
    failures: int = 0


@dataclass(frozen=True, eq=False)
class Recognition:
    """Where the body is, as seen from where it was at an earlier frame."""

    stamp_ns: int  # of that frame
    then_from_body: Pose2
    covariance: Array  # (3, 3) [m, m, rad; body]


class Landmarks:
    """Knows places by their floor. Pure: the same inputs in the same order give the same recognitions."""

    def __init__(self, patch: FloorPatch) -> None:
        """Begin with an empty map."""
        self._patch = patch
        self._range_m, self._spacing_m = RANGE_IN_REACHES * patch.reach_m, SPACING_IN_REACHES * patch.reach_m
        self._landmarks: list[Landmark] = []  # the one seen last at the end
        self._map_from_body = Pose2.identity()
        self._covariance = self._by_floor = np.zeros((3, 3))  # of where the body is; without what the wheels have added since a keyframe
        self._keyframes = self._paused = 0
        self._searched: int | None = None  # landmarks, since the robot was lifted; None: its place is known

    def __len__(self) -> int:
        """Return how many landmarks there are."""
        return len(self._landmarks)

    @property
    def map_from_body(self) -> Pose2:
        """Where the body is in this map: unlike in `odom`, its pose jumps to what is recognised."""
        return self._map_from_body

    def move(self, motion: Motion) -> None:
        """Follow the body by one step. Floor that agrees with an earlier keyframe takes back what blind steps since then have added."""
        way = motion.previous_from_body
        self._map_from_body = self._map_from_body @ way
        self._by_floor = compose_covariance(self._by_floor, way, motion.covariance if motion.from_floor else np.zeros((3, 3)))
        self._covariance = self._by_floor if motion.from_floor else compose_covariance(self._covariance, way, motion.covariance)
        self._paused += 1

    def lose(self) -> None:
        """Take the body for lifted and put down elsewhere."""
        self._searched = 0

    def look(self, glance: Glance) -> Recognition | None:
        """Look for the nearest landmark that was left some time ago, and correct the map's pose where it is recognised.

        Where the robot was lifted, look for it in the next few of all landmarks, the one seen last first.
        """
        if self._searched is not None:
            return self._search(self._searched, glance)
        if self._paused < PAUSE_FRAMES:
            return None
        candidates = [each for each in self._near(self._range_m) if self._keyframes - each.seen >= AWAY_KEYFRAMES]
        if not candidates:
            return None
        self._paused = 0
        landmark = min(candidates, key=self._distance_m)
        predicted = landmark.map_from_body.between(self._map_from_body)
        found = recognise(landmark.keyframe, glance, predicted, compose_covariance(landmark.covariance, predicted, self._covariance))
        if found is None:
            self._doubt(landmark)
            return None
        self._return_to(landmark, found)
        return Recognition(landmark.stamp_ns, found.keyframe_from_body, found.covariance)

    def enter(self, stamp_ns: int, keyframe: Keyframe, glance: Glance) -> None:
        """Enter the keyframe of the newest picture, a glance, unless the place is known; the landmark seen longest ago makes room.

        Who may be anywhere, since the wheels alone have led here, begins a new map.
        """
        self._keyframes += 1
        if self._searched is not None:
            return
        if not is_findable(self._covariance):
            self._landmarks.clear()
            self._covariance = np.zeros((3, 3))
        self._by_floor = self._covariance
        if self._near(self._spacing_m):
            return
        self._landmarks.append(
            Landmark(stamp_ns, keyframe, marks_of(self._patch, glance), self._map_from_body, self._covariance, self._keyframes)
        )
        del self._landmarks[:-MOST_LANDMARKS]

    def _search(self, searched: int, glance: Glance) -> Recognition | None:
        seen = marks_of(self._patch, glance)
        for number in range(searched, searched + min(SEARCHED_A_FRAME, len(self._landmarks))):
            landmark = self._landmarks[-1 - number % len(self._landmarks)]
            found = find(landmark.marks, landmark.keyframe, seen, glance, self._patch.cell_m)
            if found is not None:
                self._searched = None
                self._covariance = ANYWHERE
                self._return_to(landmark, found)
                return Recognition(landmark.stamp_ns, found.keyframe_from_body, found.covariance)
        self._searched = searched + SEARCHED_A_FRAME
        return None

    def _return_to(self, landmark: Landmark, found: Alignment) -> None:
        """Take the landmark's word for where the body is, unless that is known better by the way here."""
        landmark.seen, landmark.failures = self._keyframes, 0
        self._landmarks.remove(landmark)
        self._landmarks.append(landmark)
        covariance = compose_covariance(landmark.covariance, found.keyframe_from_body, found.covariance)
        if np.trace(covariance) < np.trace(self._covariance):  # a millimetre is as bad as a milliradian
            self._map_from_body = landmark.map_from_body @ found.keyframe_from_body
            self._covariance = self._by_floor = covariance

    def _doubt(self, landmark: Landmark) -> None:
        landmark.failures += 1
        if landmark.failures > MOST_FAILURES:
            self._landmarks.remove(landmark)

    def _near(self, range_m: float) -> list[Landmark]:
        return [each for each in self._landmarks if self._distance_m(each) < range_m]

    def _distance_m(self, landmark: Landmark) -> float:
        here, there = self._map_from_body, landmark.map_from_body
        return math.hypot(there.x_m - here.x_m, there.y_m - here.y_m)
