"""Robots whose batteries are low: each goes home by itself, and is parked there; the others close their ranks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

from mapserver.formation.controller import FormationController
from mapserver.formation.mission import Goal
from mapserver.formation.task import Moment, Task
from mapserver.formation.trail import Reference


class Homeward(NamedTuple):
    """What one step says."""

    others: Moment  # the same moment for the formation, to which those that leave it are lost
    references: Mapping[str, Reference]  # of those that are on their way; who is parked has none
    reason: str  # one line for a person, empty where nobody is low


class Homing:
    """Remembers where every robot was first, which is its home, and leads those home that have to go.

    Each is a formation of one with its home as the only goal, to which all others are in the way where they are now.
    """

    def __init__(self, task: Task, radii_m: Mapping[str, float]) -> None:
        """Lead any of these robots, with the speeds and the bounds of a task."""
        self._task, self._radii_m = task, dict(radii_m)
        self._homes: dict[str, Goal] = {}
        self._ways: dict[str, FormationController] = {}

    def step(self, moment: Moment, low: frozenset[str]) -> Homeward:
        """Return the references of the robots with a low battery, and the moment as the others are to see it."""
        for robot, pose in moment.poses.items():
            self._homes.setdefault(robot, (pose.x_m, pose.y_m))
        self._ways = {robot: way for robot, way in self._ways.items() if robot in low}
        leaving = sorted(low & moment.poses.keys())
        references: dict[str, Reference] = {}
        reasons: list[str] = []
        for robot in leaving:
            orders = self._way(robot).step(_alone(moment, robot))
            is_parked = orders.phase == "arrived"
            references |= {} if is_parked else orders.references
            reasons.append(f"{robot} is parked: battery low" if is_parked else f"{robot} goes home: battery low")
        return Homeward(_without(moment, leaving), references, ", ".join(reasons))

    def _way(self, robot: str) -> FormationController:
        if robot not in self._ways:
            task = replace(self._task, leader=robot, goals=(self._homes[robot],), explores=False)
            self._ways[robot] = FormationController(task, {robot: max(self._radii_m.values())})
        return self._ways[robot]


def _alone(moment: Moment, robot: str) -> Moment:
    """Return a moment in which a robot is alone, and all others are lost where they are."""
    return _without(moment, [other for other in moment.poses if other != robot])


def _without(moment: Moment, robots: list[str]) -> Moment:
    """Return a moment in which these robots count as lost where they are."""
    gone = {robot: moment.poses[robot] for robot in robots}
    here = {robot: pose for robot, pose in moment.poses.items() if robot not in gone}
    return moment._replace(poses=here, lost={**moment.lost, **gone})
