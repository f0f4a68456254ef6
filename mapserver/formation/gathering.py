"""The formation before it sets out: every robot drives to its slot by its own way, several at once where their ways keep apart."""

from __future__ import annotations

import math
from collections.abc import Mapping

from mapserver.formation.approach import Approach, approach, bodies_of, holds, keeps_clear
from mapserver.formation.costmap import CostMap
from mapserver.formation.follow import Body, Plan
from mapserver.formation.trail import Reference
from protocol.geometry import Array, Pose2

APART_M = 0.08  # between bodies that drive at the same time
TRY_EVERY_STEPS = 5
PATIENCE_S = 4.0  # with nobody on the way, or with a robot that is held up, after which gathering has failed
SETTLING_S = 2.0  # that a robot at the end of its way may take to hold its slot
SETTLED_M, SETTLED_RAD = 0.03, 0.12


class Gathering:
    """A plan, and who of its robots holds its slot already."""

    def __init__(self, plan: Plan, arc_m: float, poses: Mapping[str, Pose2], body: Body) -> None:
        """Gather for a start with the leader at `arc_m`; robots that are not on their way stay where they are now."""
        self.plan, self.arc_m, self.body = plan, arc_m, body
        slots = plan.references(arc_m, 0.0)
        self._slots = {name: slots[name].arena_from_body for name in plan.names}
        self._stands = {name: Reference(poses[name], 0.0, 0.0) for name in plan.names}
        self._ways: dict[str, Approach] = {}
        self._settling_s: dict[str, float] = {}
        self._missing = [name for name in plan.names if not holds(poses[name], self._slots[name])]
        self._idle_s = 0.0
        self._steps = 0

    def step(self, elapsed_s: float, poses: Mapping[str, Pose2], cost_map: CostMap) -> dict[str, Reference]:
        """Go on for so long and return everybody's reference."""
        if self._steps % TRY_EVERY_STEPS == 0 or not self._ways:
            self._set_out(poses, cost_map)
        self._steps += 1
        self._idle_s = 0.0 if self._ways or self.is_done() else self._idle_s + elapsed_s
        for name, way in list(self._ways.items()):
            self._stands[name] = way.advance(elapsed_s, poses[name])
            if not way.is_clear(cost_map, self.body.radius_m):
                self._turn_back(name, poses[name])
            elif way.is_done():
                self._settle(name, elapsed_s, poses[name])
        return dict(self._stands)

    def is_done(self) -> bool:
        """Tell whether everybody holds its slot."""
        return not self._missing and not self._ways

    def has_failed(self) -> bool:
        """Tell whether nobody has found a way for too long, or a robot cannot go its way, though the map shows nothing on it."""
        return self._idle_s > PATIENCE_S or any(way.waited_s > PATIENCE_S for way in self._ways.values())

    def missing(self) -> list[str]:
        """Return who does not hold its slot yet."""
        return sorted({*self._missing, *self._ways})

    def _set_out(self, poses: Mapping[str, Pose2], cost_map: CostMap) -> None:
        """Send off whoever has a way that keeps clear of all others."""
        for name in sorted(self._missing, key=lambda name: math.dist(poses[name][:2], self._slots[name][:2])):
            others = bodies_of(poses, name, self.body.radius_m)
            way = approach(poses[name], self._slots[name], others, self.body.radius_m, cost_map)
            if way is not None and self._keeps_clear(way.way_m()):
                self._ways[name] = way
                self._missing.remove(name)

    def _keeps_clear(self, way_m: Array) -> bool:
        apart_m = 2.0 * self.body.radius_m + APART_M
        return all(keeps_clear(way_m, other.way_m(), apart_m) for other in self._ways.values())

    def _turn_back(self, name: str, pose: Pose2) -> None:
        """Let a robot stop where it is, and look for another way later."""
        del self._ways[name]
        self._stands[name] = Reference(pose, 0.0, 0.0)
        self._missing.append(name)

    def _settle(self, name: str, elapsed_s: float, pose: Pose2) -> None:
        """End a robot's way once it holds its slot; one that does not get there sets out anew."""
        off = self._slots[name].between(pose)
        self._settling_s[name] = self._settling_s.get(name, 0.0) + elapsed_s
        is_there = math.hypot(off.x_m, off.y_m) <= SETTLED_M and abs(off.theta_rad) <= SETTLED_RAD
        if is_there or self._settling_s[name] > SETTLING_S:
            del self._ways[name], self._settling_s[name]
        if not is_there and name not in self._ways:
            self._missing.append(name)
