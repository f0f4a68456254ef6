"""Where the formation is to go next: along a list of goals, or to whatever is unknown and home again."""

from __future__ import annotations

from typing import Literal, Protocol

import numpy as np

from mapserver.formation.costmap import CostMap
from mapserver.formation.exploration import Frontiers, Lookout
from mapserver.formation.planning import Berth, Reach
from protocol.geometry import Array, Pose2

Goal = tuple[float, float]  # [m; arena]
Heading = Literal["moving", "exploring", "returning"]

LOOK_EVERY_STEPS = 5  # a frontier that others have seen meanwhile is not driven to


class Mission(Protocol):
    """What decides on the next goal."""

    def goal(self, cost_map: CostMap, leader: Pose2, berth: Berth) -> Goal | None:
        """Return where to go now, the leader being at `leader`; None: all is done."""
        ...

    def reached(self) -> None:
        """Take note that the goal was reached."""
        ...

    def give_up(self) -> None:
        """Take note that there is no way to the goal now."""
        ...

    @property
    def heading(self) -> Heading:
        """What the drive to the goal is called."""
        ...


class GoalList:
    """Goals one after the other."""

    heading: Heading = "moving"

    def __init__(self, goals: tuple[Goal, ...]) -> None:
        """Begin with the first."""
        self._goals = list(goals)

    def goal(self, cost_map: CostMap, leader: Pose2, berth: Berth) -> Goal | None:
        """Return the goal that is next."""
        return self._goals[0] if self._goals else None

    def reached(self) -> None:
        """Go on to the next one."""
        self._goals.pop(0)

    def give_up(self) -> None:
        """Keep the goal: the way may become free."""


class Exploration:
    """Frontiers for as long as there are any, then home: to where the leader was first asked for."""

    def __init__(self) -> None:
        """Begin without a lookout."""
        self._frontiers = Frontiers()
        self._lookout: Lookout | None = None
        self._home: Goal | None = None
        self._is_home = False
        self._steps = 0
        self.heading: Heading = "exploring"

    def goal(self, cost_map: CostMap, leader: Pose2, berth: Berth) -> Goal | None:
        """Return the lookout that is next, or home."""
        if self._home is None:
            self._home = leader.x_m, leader.y_m
        self._steps += 1
        if self.heading == "exploring" and (self._lookout is None or self._is_seen(cost_map)):
            self._lookout = self._frontiers.best(cost_map, Reach(cost_map, np.array(leader[:2]), berth), leader)
            self.heading = "returning" if self._lookout is None else "exploring"
        if self._lookout is not None:
            return _goal(self._lookout.place_m)
        return None if self._is_home else self._home

    def reached(self) -> None:
        """Be done with the lookout, whatever it showed; or be at home."""
        self._is_home = self._lookout is None
        self.give_up()

    def give_up(self) -> None:
        """Look elsewhere; home alone is worth waiting for."""
        if self._lookout is not None:
            self._frontiers.ban(self._lookout)
            self._lookout = None

    def _is_seen(self, cost_map: CostMap) -> bool:
        assert self._lookout is not None
        return self._steps % LOOK_EVERY_STEPS == 0 and not self._frontiers.is_dark(cost_map, self._lookout)


def _goal(place_m: Array) -> Goal:
    x_m, y_m = np.asarray(place_m, dtype=np.float64).tolist()
    return x_m, y_m
