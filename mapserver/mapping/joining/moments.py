"""What is remembered of a robot without a place, a seeker: glances, at which it and others looked around, and what they mean by now."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from mapserver.mapping.belief import Belief
from mapserver.mapping.poses.association import associate
from protocol.geometry import Pose2
from protocol.messages import LocalMap, Sighting

MOST_GLANCES = 12
SPELL_M, SPELL_RAD = 0.05, 0.1  # until somebody has moved so far, all errors repeat, and so does what is seen
LATEST_NS = 250_000_000  # a local map of somebody else that is older belongs to another glance
WELL_KNOWN = np.diag([1e-4, 1e-4, 1e-4])  # 1 cm and 0.6 degrees: of a robot that has a place

PoseAt = Callable[[str, int], Pose2 | None]  # arena_from_body of a robot at a stamp [ns]; None where that is not known


class Glance(NamedTuple):
    """One local map of the seeker, and the latest of all others."""

    local_map: LocalMap
    others: tuple[LocalMap, ...]

    def looks(self) -> int:
        """Return how many sightings it holds."""
        return sum(len(each.sightings) for each in (self.local_map, *self.others))

    def repeats(self, earlier: Glance) -> bool:
        """Tell whether everybody stands as at an earlier glance, so that what is seen tells the same."""
        before = {each.robot: each for each in (earlier.local_map, *earlier.others)}
        return all(each.robot in before and _is_still(before[each.robot], each) for each in (self.local_map, *self.others))


class View(NamedTuple):
    """What a robot that has a place saw, and where the seeker was then, by its own odometry."""

    local_map: LocalMap
    arena_from_body: Pose2
    strangers: tuple[Sighting, ...]  # which show none of the robots that have a place
    start_from_seeker: Pose2


class Moment(NamedTuple):
    """A glance in the light of who has a place by now; `start` is the frame in which the seeker's path is kept."""

    local_map: LocalMap
    start_from_body: Pose2
    robots: dict[str, Pose2]  # arena_from_body of those that have a place, at the stamp of the local map
    views: tuple[View, ...]


def remembered(glances: Sequence[Glance], new: Glance) -> tuple[Glance, ...]:
    """Return the glances with a new one: of two that repeat each other that with more looks is kept, of all others the latest."""
    if glances and new.repeats(glances[-1]):
        return (*glances[:-1], new) if new.looks() > glances[-1].looks() else tuple(glances)
    return (*glances, new)[-MOST_GLANCES:] if new.looks() else tuple(glances)


def moment_of(glance: Glance, pose_at: PoseAt, start_from_body_at: Callable[[int], Pose2]) -> Moment:
    """Return what a glance means, given where the others were and how the seeker had moved."""
    stamp_ns = glance.local_map.stamp_ns
    robots = {each.robot: pose for each in glance.others if (pose := pose_at(each.robot, stamp_ns)) is not None}
    views = tuple(_view(each, robots, pose_at, start_from_body_at(each.stamp_ns)) for each in glance.others if each.robot in robots)
    return Moment(glance.local_map, start_from_body_at(stamp_ns), robots, views)


def _view(local_map: LocalMap, robots: dict[str, Pose2], pose_at: PoseAt, start_from_seeker: Pose2) -> View:
    own = pose_at(local_map.robot, local_map.stamp_ns) or robots[local_map.robot]
    others = {robot: Belief(pose, WELL_KNOWN) for robot, pose in robots.items() if robot != local_map.robot}
    explained = [match.sighting for match in associate(local_map.sightings, Belief(own, WELL_KNOWN), others)]
    strangers = tuple(each for each in local_map.sightings if not any(each is known for known in explained))
    return View(local_map, own, strangers, start_from_seeker)


def _is_still(before: LocalMap, now: LocalMap) -> bool:
    if before.epoch != now.epoch:
        return False
    moved = Pose2(*before.odom_from_body).between(Pose2(*now.odom_from_body))
    return float(np.hypot(moved.x_m, moved.y_m)) < SPELL_M and abs(moved.theta_rad) < SPELL_RAD
