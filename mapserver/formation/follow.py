"""One plan for all: the leader's trail, a lane for each follower, and how far it keeps back, as functions of how far the leader is.

Everybody's reference follows from two numbers, the leader's arc length and how fast that grows. So a formation that is slowed down or
stopped anywhere keeps its shape, and no reference ever jumps.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mapserver.formation.costmap import CostMap
from mapserver.formation.falling_in import Spacing, backs_along, closest_along
from mapserver.formation.narrowing import blended, lefts_along
from mapserver.formation.speeds import speeds_along
from mapserver.formation.trail import STEP_M, Lane, Reference, sample
from protocol.geometry import Array

USUAL_SIDE_M, TIGHT_SIDE_M = 0.035, 0.023  # that the leader's way is planned with; tight where no other way leads to the goal
LEAST_SIDE_M = 0.02  # between bodies and things; what comes nearer, stops the plan there
STEADY_TURN, STEADY_REACH_M = 2.0, 0.1  # [rad/m] the most that a steady leader's trail bends, so far around it
LOOSE_SIDE_M = 0.01  # what has turned out so near does not stop the plan ...
NEAR_M, FAR_M = 0.15, 0.6  # ... nearer than this, where it is too late to give way, and farther, where the map knows no better yet
SIGHT_M = 1.5  # ahead of the leader that is checked again in every step
STOP_BEFORE_M = 0.05
MEETING_M = 0.015  # robots may come so much nearer than planned


@dataclass(frozen=True)
class Plan:
    """Row and lane 0 are the leader's; followers come in the order of a column. `trail` is sampled as lanes are."""

    names: tuple[str, ...]
    offsets: Array  # (k, 2) of the followers' slots (back, left) [m]
    lefts_m: Array  # (k, n) at the followers' own arc lengths
    backs_m: Array  # (k, n) at the leader's
    lanes: tuple[Lane, ...]
    speeds_m_s: Array  # (n,) that the leader's arc length may have
    goal_m: tuple[float, float]

    @property
    def leader(self) -> str:
        """Who leads."""
        return self.names[0]

    @property
    def trail(self) -> Lane:
        """The curve that the leader drives."""
        return self.lanes[0]

    def references(self, arc_m: float, rate_m_s: float) -> dict[str, Reference]:
        """Return everybody's reference, the leader's arc length being `arc_m` and growing by `rate_m_s`."""
        found = {self.leader: self.trail.at(arc_m, rate_m_s)}
        for number, name in enumerate(self.names[1:]):
            back_m = self.backs_m[number]
            pace = 1.0 - float(sample(back_m, arc_m + STEP_M) - sample(back_m, arc_m - STEP_M)) / (2.0 * STEP_M)
            found[name] = self.lanes[number + 1].at(arc_m - float(sample(back_m, arc_m)), rate_m_s * pace)
        return found

    def slots(self, arc_m: float) -> dict[str, tuple[float, float]]:
        """Return everybody's place in the leader's body frame [m]."""
        references = self.references(arc_m, 0.0)
        leader_from_arena = references[self.leader].arena_from_body.inverse()
        return {name: _rounded(leader_from_arena.apply(reference.arena_from_body[:2])) for name, reference in references.items()}

    def is_open(self, arc_m: float, tolerance_m: float) -> bool:
        """Tell whether nobody gives way: all followers keep their shape's own offsets, measured along the trail and from it."""
        return bool((self.drawn_in_m(np.array([arc_m])) <= tolerance_m).all())

    def drawn_in_m(self, arcs_m: Array) -> Array:
        """Return how far every follower is from its place in the open shape, shape (k, n) [m], the leader being at `arcs_m`, (n,)."""
        backs_m = np.array([sample(row, arcs_m) for row in self.backs_m]).reshape(-1, len(arcs_m))
        lefts_m = np.array([sample(row, arcs_m - back_m) for row, back_m in zip(self.lefts_m, backs_m, strict=True)]).reshape(backs_m.shape)
        return np.hypot(backs_m - self.offsets[:, :1], lefts_m - self.offsets[:, 1:])

    def is_steady(self, arc_m: float, tolerance_m: float) -> bool:
        """Tell whether nobody gives way, and the leader does not turn aside either."""
        around_m = arc_m + np.linspace(-STEADY_REACH_M, STEADY_REACH_M, 11)
        return self.is_open(arc_m, tolerance_m) and bool(np.abs(sample(self.trail.turns, around_m)).max() <= STEADY_TURN)

    def clear_until_m(self, arc_m: float, radius_m: float, cost_map: CostMap, robots: int | None = None) -> float:
        """Return the arc length of the leader up to which nobody touches anything on the map; the trail's end where all is clear.

        Only so many `robots` count, the leader first, if that is given. Whoever is nearer to something already may go on to where it is not
        any nearer.
        """
        count = len(self.trail.points_m)
        ahead_m = STEP_M * np.arange(int(arc_m / STEP_M), min(int((arc_m + SIGHT_M) / STEP_M) + 1, count))
        least_m = sides_m(ahead_m - arc_m) + radius_m
        touching = np.zeros(len(ahead_m), dtype=bool)
        for number in range(len(self.names))[:robots]:
            arcs_m = ahead_m - sample(self.backs_m[number - 1], ahead_m) if number else ahead_m
            touching |= cost_map.too_near(sample(self.lanes[number].points_m, arcs_m), least_m)
        return float(ahead_m[np.argmax(touching)]) if touching.any() else self.trail.length_m


def sides_m(ahead_m: NDArray[Any]) -> Array:
    """Return how much must be left, (n,) [m], between a body and things that are so far ahead of the leader, (n,)."""
    return np.asarray(np.where((ahead_m > NEAR_M) & (ahead_m < FAR_M), LEAST_SIDE_M, LOOSE_SIDE_M))


@dataclass(frozen=True)
class Body:
    """What all robots of a formation have in common."""

    radius_m: float
    cruise_m_s: float
    most_m_s: float
    side_m: float = USUAL_SIDE_M  # between the leader's body and things, at least, where it plans its way

    @property
    def spacing(self) -> Spacing:
        """How near they come to each other."""
        return Spacing.of(self.radius_m)


def make_plan(
    trail: Lane,
    arc_m: float,
    names: tuple[str, ...],
    offsets: Array,
    body: Body,
    cost_map: CostMap,
    goal_m: tuple[float, float],
    held: Plan | None = None,
) -> Plan:
    """Return the plan to drive along a trail, the leader being at `arc_m`, and where another plan is held to, going on from that one.

    `names` has the leader first, `offsets`, shape (k, 2), ascend in how far back they are.
    """
    backs_now_m = offsets[:, 0] if held is None else sample(held.backs_m.T, arc_m)
    lefts_m = lefts_along(trail, offsets, arc_m - backs_now_m, body.radius_m, cost_map)
    if held is not None:
        lefts_m = _each_blended(held.lefts_m, lefts_m, arc_m - backs_now_m)
    lanes = (trail, *(trail.beside(left_m) for left_m in lefts_m))
    backs_m = backs_along(lanes, offsets[:, 0], arc_m, body.spacing, None if held is None else held.backs_m)
    room_m = cost_map.clearance_m(trail.points_m).astype(np.float64) - body.radius_m
    speeds_m_s = speeds_along(lanes, backs_m, room_m, body.cruise_m_s, body.most_m_s)
    return Plan(names, offsets, lefts_m, backs_m, lanes, speeds_m_s, goal_m)


def meets_from_m(plan: Plan, arc_m: float, body: Body) -> float:
    """Return the arc length of the leader from which two robots of a plan would come too near, its end where none do."""
    apart_m = closest_along(plan.lanes, plan.backs_m)
    first = int(arc_m / STEP_M)
    near = apart_m < min(body.spacing.least_m - MEETING_M, apart_m[first] - MEETING_M)  # who stands nearer may part
    near[:first] = False
    return STEP_M * int(np.argmax(near)) if near.any() else plan.trail.length_m


def _each_blended(old: Array, new: Array, from_arcs_m: Array) -> Array:
    rows = zip(old, new, from_arcs_m, strict=True)
    return np.array([blended(old_row, new_row, float(arc_m)) for old_row, new_row, arc_m in rows]).reshape(new.shape)


def _rounded(place_m: Array) -> tuple[float, float]:
    return float(place_m[0]), float(place_m[1])
