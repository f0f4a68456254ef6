"""How a trail goes on to a goal from where it ends now: straight into the route, or round a bend first, where the route leads back."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from mapserver.formation.costmap import CostMap
from mapserver.formation.follow import Body, Plan, make_plan, meets_from_m
from mapserver.formation.planning import Berth, Reach
from mapserver.formation.smoothing import smooth
from mapserver.formation.trail import STEP_M, Lane
from protocol.geometry import Array

WISHED_M = 0.30
SHARPEST_TURN, BEND_M = 1.0 / 0.10, 0.6  # [rad/m], in the next so many metres
LOOKAHEAD_M = 0.12  # ahead of the leader, within which its trail stays as it is
NEAR_M = 0.03  # a goal so near is reached
BEND_RADII_M = (0.17, 0.26)  # of bends that are tried before the route: two of the smaller keep a column clear of itself
BEND_ANGLES_RAD = (0.7, 1.2, 1.7, 2.2, 2.7, 3.1)
BENDS_TRIED = 4


def berth_of(body: Body) -> Berth:
    """Return how far the leader keeps from things."""
    return Berth(body.radius_m + body.side_m, body.radius_m + WISHED_M)


class _Bend(NamedTuple):
    """A bend at the end of a trail, and what it costs to go to the goal by it."""

    cost: float
    points_m: Array  # (n, 2) [arena], one every STEP_M


def ways_on(kept_m: Array, from_goal: Reach, body: Body, cost_map: CostMap) -> Iterator[Lane]:
    """Yield trails that go on from `kept_m`, shape (n, 2), to where a reach began, without a sharp bend, the straight way first."""
    bends = [_Bend(0.0, kept_m[:0]), *sorted(_bends(kept_m, from_goal, body, cost_map), key=lambda bend: bend.cost)[:BENDS_TRIED]]
    for bend in bends:
        trail = _continued(np.vstack([kept_m, bend.points_m]), from_goal, body, cost_map)
        if trail is not None and not _is_sharp(trail, len(kept_m) - 1):
            yield trail


def way_on_from_rest(kept_m: Array, from_goal: Reach, body: Body, cost_map: CostMap) -> Lane | None:
    """Return the trail that goes on to where a reach began, however sharply it bends at first: a leader that stands can turn there."""
    return _continued(kept_m, from_goal, body, cost_map)


def go_on(plan: Plan, arc_m: float, goal_m: tuple[float, float], body: Body, cost_map: CostMap) -> Plan | None:
    """Return a plan with a new way from just ahead of the driving leader, or None where there is none without stopping."""
    kept_m = plan.trail.points_m[: int((arc_m + LOOKAHEAD_M) / STEP_M) + 2]
    for trail in ways_on(kept_m, Reach(cost_map, np.array(goal_m), berth_of(body)), body, cost_map):
        made = make_plan(trail, arc_m, plan.names, plan.offsets, body, cost_map, goal_m, plan)
        until_m = min(made.clear_until_m(arc_m, body.radius_m, cost_map), meets_from_m(made, arc_m, body))
        if until_m >= min(arc_m + BEND_M, trail.length_m):
            return made
    return None


def narrowed_anew(plan: Plan, arc_m: float, body: Body, cost_map: CostMap) -> Plan:
    """Return a plan on the same trail, whose followers give way to what is on the map by now."""
    return make_plan(plan.trail, arc_m, plan.names, plan.offsets, body, cost_map, plan.goal_m, plan)


def _continued(kept_m: Array, reach: Reach, body: Body, cost_map: CostMap) -> Lane | None:
    """Return the trail that goes on along the route, or None where there is no route."""
    back_m = reach.route(kept_m[-1])
    if back_m is None:
        return None
    if math.dist(back_m[0], kept_m[-1]) <= NEAR_M:
        return Lane.through(kept_m)
    route_m = np.vstack([kept_m[-1], back_m[-2::-1]])
    return Lane.through(np.vstack([kept_m, smooth(route_m, kept_m, cost_map, berth_of(body))]))


def _bends(kept_m: Array, reach: Reach, body: Body, cost_map: CostMap) -> Iterator[_Bend]:
    """Yield the bends to either side for which there is room."""
    ahead = kept_m[-1] - kept_m[-2]
    ahead = ahead / float(np.hypot(*ahead))
    for radius_m in BEND_RADII_M:
        for left in (np.array([-ahead[1], ahead[0]]), np.array([ahead[1], -ahead[0]])):
            for angle_rad in BEND_ANGLES_RAD:
                turns = np.arange(1, round(radius_m * angle_rad / STEP_M) + 1)[:, None] * (STEP_M / radius_m)
                points_m = kept_m[-1] + radius_m * (np.sin(turns) * ahead + (1.0 - np.cos(turns)) * left)
                if cost_map.clearance_m(points_m).min() < body.radius_m + body.side_m:
                    break
                yield _Bend(reach.cost_to(points_m[-1]) + radius_m * angle_rad, points_m)


def _is_sharp(trail: Lane, first: int) -> bool:
    """Tell whether a trail bends sharply just after its sample `first`; what lies further ahead is planned again before that."""
    return bool(np.abs(trail.turns[first : first + round(BEND_M / STEP_M)]).max(initial=0.0) > SHARPEST_TURN)
