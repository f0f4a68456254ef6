"""Plans from a standstill: which way the formation is to face, its trail behind and ahead of the leader, and who takes which slot."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np

from mapserver.formation.approach import approach, bodies_of
from mapserver.formation.assignment import assign, total_distance_m
from mapserver.formation.costmap import CostMap
from mapserver.formation.falling_in import column_backs
from mapserver.formation.follow import LEAST_SIDE_M, Body, Plan, make_plan, meets_from_m
from mapserver.formation.onward import NEAR_M, berth_of, ways_on
from mapserver.formation.planning import Reach
from mapserver.formation.shapes import Shape, follower_offsets
from mapserver.formation.standing import plan_as_they_stand
from mapserver.formation.trail import STEP_M, Lane, resampled, sample
from protocol.geometry import Array, Pose2, wrap_angle

FACING_REACH_M = 0.25  # of the route, whose direction the formation may take
KEEPS_HEADING_RAD = 1.3  # the leader need not turn on the spot for less
OTHER_TURNS_RAD = (0.0, 0.5, -0.5, 1.0, -1.0, 1.6, -1.6, 2.4, -2.4)
SPARE_TAIL_M = 0.10
TURNING_M_RAD = 0.1  # of way that a radian's turn on the spot is worth
STOOD_M = 0.03  # a leader so near to the end of its old trail stands on it
LITTLE_M, MOST_COMPARED = 0.4, 4  # of effort, with which no other start is looked for; starts that are compared
HINDERED_M = 1.5  # of way that it counts as, where others stand in the way to a slot, or would later meet
START_M = 0.2  # of the trail that have to be clear for a start
BENT_TAILS, BENT_TRIED, BENT_COST = 48, 6, 2.0  # ways behind the leader that are compared, and tried; their cost a metre


class Start(NamedTuple):
    """A plan, where the leader begins on it, and how far all have to go in all before they hold their slots, turns included."""

    plan: Plan
    arc_m: float
    effort_m: float


def form_up(
    poses: Mapping[str, Pose2],
    leader: str,
    goal_m: tuple[float, float],
    from_goal: Reach,
    shape: Shape,
    body: Body,
    cost_map: CostMap,
    stood_m: Array | None = None,
) -> Start | None:
    """Return a plan from where the robots stand, or None where no way leads to the goal.

    `from_goal` is the reach from the goal; `stood_m`, shape (n, 2), is the trail along which they stand already, if they do.
    """
    followers = {name: pose for name, pose in poses.items() if name != leader}
    offsets = _in_column_order(follower_offsets(shape, len(followers)))
    reach = Reach(cost_map, np.array(poses[leader][:2]), berth_of(body))
    route_m = reach.route(np.array(goal_m))
    if route_m is None:
        return None
    backs_m = column_backs(offsets[:, 0], body.spacing.column_m)
    length_m = max(backs_m.max(initial=0.0), offsets[:, 0].max(initial=0.0)) + SPARE_TAIL_M
    farthest_m = max((math.dist(pose[:2], poses[leader][:2]) for pose in followers.values()), default=0.0)
    straight = (
        _straight(route_m[0], heading_rad, max(length_m, farthest_m + SPARE_TAIL_M)) for heading_rad in _headings(poses[leader], route_m)
    )
    stood = [] if stood_m is None or math.dist(stood_m[-1], poses[leader][:2]) > STOOD_M else [stood_m]
    formed = plan_as_they_stand(poses, leader, (*stood, *straight), offsets, goal_m, from_goal, body, cost_map)
    if formed is not None:
        return Start(*formed, _effort_m(*formed, poses, body, cost_map))
    stood_m = None if stood_m is None else stood_m[-round(length_m / STEP_M) - 1 :]
    started: list[Start] = []
    for tail_m in _tails(poses[leader], list(followers.values()), route_m, backs_m, length_m, reach, stood_m):
        arc_m = (len(tail_m) - 1) * STEP_M
        for trail in ways_on(tail_m, from_goal, body, cost_map):
            plan = _manned(trail, arc_m, leader, followers, offsets, body, cost_map, goal_m)
            if _can_start(plan, arc_m, body, cost_map):
                started.append(Start(plan, arc_m, _effort_m(plan, arc_m, poses, body, cost_map)))
                break
        if started and (started[-1].effort_m < LITTLE_M or len(started) == MOST_COMPARED):
            break
    return min(started, key=lambda start: start.effort_m, default=None)


def _effort_m(plan: Plan, arc_m: float, poses: Mapping[str, Pose2], body: Body, cost_map: CostMap) -> float:
    """Return how far all have to go to their slots, round each other and round things, turns included; more where they would meet later."""
    effort_m = HINDERED_M if meets_from_m(plan, arc_m, body) < plan.trail.length_m else 0.0
    for name, reference in plan.references(arc_m, 0.0).items():
        slot = reference.arena_from_body
        way = approach(poses[name], slot, bodies_of(poses, name, body.radius_m), body.radius_m, cost_map)
        effort_m += TURNING_M_RAD * abs(slot.between(poses[name]).theta_rad)
        effort_m += HINDERED_M if way is None else 0.0 if way.lane is None else way.lane.length_m
    return effort_m


def _can_start(plan: Plan, arc_m: float, body: Body, cost_map: CostMap) -> bool:
    """Tell whether nothing stands between the robots of a plan, nor just ahead of any."""
    rearmost_m = arc_m - float(sample(plan.backs_m.T, arc_m).max(initial=0.0))
    between_m = plan.trail.points_m[max(int(rearmost_m / STEP_M), 0) : int(arc_m / STEP_M) + 1]
    until_m = min(arc_m + START_M, plan.trail.length_m)
    is_open = cost_map.clearance_m(between_m).min() >= body.radius_m + LEAST_SIDE_M
    return bool(is_open and min(plan.clear_until_m(arc_m, body.radius_m, cost_map), meets_from_m(plan, arc_m, body)) >= until_m)


def _manned(
    trail: Lane,
    arc_m: float,
    leader: str,
    followers: Mapping[str, Pose2],
    offsets: Array,
    body: Body,
    cost_map: CostMap,
    goal_m: tuple[float, float],
) -> Plan:
    """Return the plan along a trail, each slot with the robot that has the shortest way."""
    unmanned = make_plan(trail, arc_m, (leader, *sorted(followers)), offsets, body, cost_map, goal_m)
    places_m = [
        sample(lane.points_m, arc_m - float(sample(back_m, arc_m)))
        for lane, back_m in zip(unmanned.lanes[1:], unmanned.backs_m, strict=True)
    ]
    names = assign(followers, np.array(places_m).reshape(-1, 2))
    return make_plan(trail, arc_m, (leader, *names), offsets, body, cost_map, goal_m)


def _in_column_order(offsets: Array) -> Array:
    """Return the offsets as they follow each other in a column: the foremost first, of those side by side the innermost."""
    return offsets[np.lexsort((-offsets[:, 1], np.abs(offsets[:, 1]), np.round(offsets[:, 0], 3)))]


def _tails(
    leader: Pose2, followers: list[Pose2], route_m: Array, backs_m: Array, length_m: float, reach: Reach, stood_m: Array | None
) -> Iterator[Array]:
    """Yield trails behind the leader, shape (n, 2), ending in its place: as they stand, straight ones, those along which followers are."""
    if stood_m is not None:
        yield from _as_they_stand(leader, stood_m, length_m)
    for heading_rad in _headings(leader, route_m):
        yield _straight(route_m[0], heading_rad, length_m)
    if followers:
        yield from _bent(followers, route_m, backs_m, length_m, reach)


def _as_they_stand(leader: Pose2, stood_m: Array, length_m: float) -> Iterator[Array]:
    """Yield the trail along which the formation stands, up to its leader; and back from its front, to a leader that stands at its rear."""
    nearest = int(np.argmin(np.hypot(*(stood_m - leader[:2]).T)))
    if math.dist(stood_m[nearest], leader[:2]) > STOOD_M:
        return
    samples = round(length_m / STEP_M) + 1
    if nearest + 1 >= samples:
        yield stood_m[nearest + 1 - samples : nearest + 1]
    back_m = stood_m[nearest:][::-1]
    missing = samples - len(back_m)
    if len(back_m) > 1 and missing <= round(2.0 * SPARE_TAIL_M / STEP_M):
        heading_rad = math.atan2(*(back_m[1] - back_m[0])[::-1])
        yield np.vstack([_straight(back_m[0], heading_rad, missing * STEP_M)[:-1], back_m]) if missing > 0 else back_m[-samples:]


def _bent(followers: list[Pose2], route_m: Array, backs_m: Array, length_m: float, reach: Reach) -> Iterator[Array]:
    """Yield the best of the cheapest ways to the leader, of those that do not begin where its route leads on."""
    onward_m = _towards(route_m)
    samples = round(length_m / STEP_M) + 1
    ways_m = [resampled(way_m, STEP_M)[:samples] for way_m in reach.routes_of_cost(BENT_COST * length_m, BENT_TAILS)]
    ways_m = [way_m for way_m in ways_m if len(way_m) == samples and float(_towards(way_m) @ onward_m) < 0.0]
    places_m = np.array([pose[:2] for pose in followers])
    for way_m in sorted(ways_m, key=lambda way_m: total_distance_m(places_m, sample(way_m, backs_m)))[:BENT_TRIED]:
        yield way_m[::-1]


def _towards(way_m: Array) -> Array:
    """Return the unit vector, shape (2,), in which a way sets out."""
    ahead_m = resampled(way_m, FACING_REACH_M)[1] - way_m[0]
    return np.asarray(ahead_m / max(float(np.hypot(*ahead_m)), 1e-9))


def _headings(leader: Pose2, route_m: Array) -> list[float]:
    """Return which ways the formation may face: as its leader does, if that is about right, else along the route or aside of it."""
    way_m = resampled(route_m, FACING_REACH_M)
    along_rad = math.atan2(*(way_m[1] - way_m[0])[::-1]) if len(route_m) > 1 else leader.theta_rad
    if math.dist(route_m[0], route_m[-1]) <= NEAR_M:
        along_rad = leader.theta_rad
    as_it_is = [leader.theta_rad] if abs(wrap_angle(along_rad - leader.theta_rad)) <= KEEPS_HEADING_RAD else []
    return as_it_is + [along_rad + turn_rad for turn_rad in OTHER_TURNS_RAD]


def _straight(end_m: Array, heading_rad: float, length_m: float) -> Array:
    backs_m = STEP_M * np.arange(round(length_m / STEP_M), -1, -1)
    return np.asarray(end_m - backs_m[:, None] * np.array([math.cos(heading_rad), math.sin(heading_rad)]))
