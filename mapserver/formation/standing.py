"""Plans that begin with every robot where it stands: followers take their slots on the way, beside a trail that leads on from its leader.

So nobody has to manoeuvre before the formation sets out. A follower that stands ahead of its leader has to take its slot first
(gathering.py).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace

import numpy as np

from mapserver.formation.assignment import assign
from mapserver.formation.costmap import CostMap
from mapserver.formation.follow import Body, Plan, make_plan, meets_from_m
from mapserver.formation.onward import way_on_from_rest, ways_on
from mapserver.formation.planning import Reach
from mapserver.formation.trail import STEP_M, Lane
from protocol.geometry import Array, Pose2

LEAST_BACK_M = 0.05  # so far behind its leader a follower can still take its slot on the way
CLEAR_M = 0.25  # of the way that has to be clear for everybody


def plan_as_they_stand(
    poses: Mapping[str, Pose2],
    leader: str,
    tails: Iterable[Array],
    offsets: Array,
    goal_m: tuple[float, float],
    from_goal: Reach,
    body: Body,
    cost_map: CostMap,
) -> tuple[Plan, float] | None:
    """Return the first plan that can start at once, and the leader's arc length on it; None where none can.

    `tails`, (n, 2) each, are curves that end in the leader's place; `offsets`, (k, 2), are the followers' slots (back, left) [m],
    `from_goal` is the reach from the goal.
    """
    followers = {name: np.array(pose[:2]) for name, pose in poses.items() if name != leader}
    for tail_m in tails:
        places = _beside(tail_m, followers)
        if any(back_m < LEAST_BACK_M for back_m, _ in places.values()):
            continue
        names = assign({name: Pose2(back_m, left_m, 0.0) for name, (back_m, left_m) in places.items()}, offsets)
        now = np.array([places[name] for name in names]).reshape(-1, 2)
        for trail in _trails(tail_m, from_goal, body, cost_map):
            arc_m = (len(tail_m) - 1) * STEP_M
            plan = _plan_from(now, trail, arc_m, (leader, *names), offsets, goal_m, body, cost_map)
            if min(plan.clear_until_m(arc_m, body.radius_m, cost_map), meets_from_m(plan, arc_m, body)) >= min(
                arc_m + CLEAR_M, trail.length_m
            ):
                return plan, arc_m
    return None


def _trails(tail_m: Array, from_goal: Reach, body: Body, cost_map: CostMap) -> Iterator[Lane]:
    """Yield trails from a tail on: gentle ones first, then the one for which the leader has to turn on the spot."""
    yield from ways_on(tail_m, from_goal, body, cost_map)
    sharp = way_on_from_rest(tail_m, from_goal, body, cost_map)
    if sharp is not None:
        yield sharp


def _beside(tail_m: Array, followers: Mapping[str, Array]) -> dict[str, tuple[float, float]]:
    """Return how far back along a tail, and how far to its left, robots at places, (2,) each, stand [m]; not back where it ends first."""
    normals = Lane.through(tail_m).normals()
    found = {}
    for name, place_m in followers.items():
        nearest = int(np.argmin(np.hypot(*(tail_m - place_m).T)))
        left_m = float((place_m - tail_m[nearest]) @ normals[nearest])
        found[name] = ((len(tail_m) - 1 - nearest) * STEP_M if nearest > 0 else -1.0, left_m)
    return found


def _plan_from(
    now: Array,
    trail: Lane,
    arc_m: float,
    names: tuple[str, ...],
    offsets: Array,
    goal_m: tuple[float, float],
    body: Body,
    cost_map: CostMap,
) -> Plan:
    """Return the plan that goes over from where followers are, rows (back, left) of `now`, to their slots."""
    wished = make_plan(trail, arc_m, names, offsets, body, cost_map, goal_m)
    everywhere = np.ones(len(trail.points_m))
    held = replace(wished, lefts_m=now[:, 1:] * everywhere, backs_m=now[:, :1] * everywhere)
    return make_plan(trail, arc_m, names, offsets, body, cost_map, goal_m, held)
