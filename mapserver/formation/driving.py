"""The formation under way: it goes on as far as the map is clear and nobody falls behind, and mends its plan as the map grows."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from mapserver.formation.costmap import CostMap
from mapserver.formation.follow import STOP_BEFORE_M, Body, Plan, meets_from_m
from mapserver.formation.onward import LOOKAHEAD_M, berth_of, go_on, narrowed_anew
from mapserver.formation.planning import Reach, cost_of_way
from mapserver.formation.speeds import ACCELERATION_M_S2
from mapserver.formation.trail import STEP_M, Reference, sample
from protocol.geometry import Array, Pose2

NEAR_M, FAR_M = 0.05, 0.15  # a robot's distance from its reference at which the formation slows down, and at which it waits
BETWEEN_M, CLOSING = 0.05, 0.2  # between a reference and where another robot is: nearer, none goes on towards it; of the leader's way ...
LEEWAY = 3.0  # ... where that is fewer times as far off as the other has fallen behind
BRAKING_M_S2 = 0.3
REVIEW_EVERY_STEPS = 5
WORTH_SHARE, WORTH_M = 0.85, 0.2  # a new way has to cost less than this share of the old one's, and less by so much
OPEN_REACH_M, OPEN_SAMPLES, OPENING_M = 1.2, 25, 0.01  # ahead of the leader, over which followers have to come nearer in the mean
WAITING_S, PATIENCE_S = 3.0, 1.0  # held up for so long by a robot, or by a thing, a formation forms up anew from where its robots are
STILL_M = 0.03  # a robot that moves by more is not held up
TURNING_M = 0.35  # before what stands in the leader's own way it stops, while there is room to turn
ARRIVED_M = 0.27
AT_REST_M_S = 1e-3


class Driving:
    """A plan, and how far along it the formation is."""

    def __init__(self, plan: Plan, arc_m: float, body: Body) -> None:
        """Begin at rest, the leader at `arc_m` of the plan's trail."""
        self.plan, self.arc_m, self._body = plan, arc_m, body
        self._rate_m_s = 0.0
        self._meets_m = meets_from_m(plan, arc_m, body)
        self._clear_m = plan.trail.length_m
        self._held_s = 0.0
        self._waited_at_m = (math.inf, math.inf)  # where whoever has fallen behind was seen to stand
        self._is_braking = False
        self._steps = 0
        self.waits_for = ""  # who has fallen behind

    def brake(self) -> None:
        """Come to rest, for good."""
        self._is_braking = True

    def turn_to(self, goal_m: tuple[float, float], cost_map: CostMap) -> None:
        """Go to another goal, without stopping where that can be."""
        plan = go_on(self.plan, self.arc_m, goal_m, self._body, cost_map)
        if plan is None:
            self.brake()
        else:
            self._take(plan)

    def step(self, elapsed_s: float, poses: Mapping[str, Pose2], cost_map: CostMap) -> dict[str, Reference]:
        """Go on for so long and return everybody's reference."""
        self._mend(cost_map)
        before_m_s = self._rate_m_s
        self._rate_m_s = self._next_rate(elapsed_s, self._patience(poses))
        self.arc_m = min(self.arc_m + 0.5 * (before_m_s + self._rate_m_s) * elapsed_s, self.plan.trail.length_m)
        self._held_s = self._held_s + elapsed_s if self._is_held_up(poses) else 0.0
        return self.plan.references(self.arc_m, self._rate_m_s)

    def stood_m(self) -> Array:
        """Return the trail behind the leader, shape (n, 2) [m; arena], along which the formation stands."""
        return self.plan.trail.points_m[: round(self.arc_m / STEP_M) + 1]

    def is_at_end(self) -> bool:
        """Tell whether the trail's end is reached."""
        return self.plan.trail.length_m - self.arc_m < 0.5 * STEP_M

    def has_arrived(self) -> bool:
        """Tell whether the leader is where it was to go."""
        off_m = math.dist(self.plan.trail.points_m[-1], self.plan.goal_m)
        return self.is_at_end() and off_m <= ARRIVED_M

    def is_over(self) -> bool:
        """Tell whether there is nothing more to drive: it stands, at the end, for good, or because it is held up."""
        patience_s = PATIENCE_S if self.is_blocked() else WAITING_S
        return self.is_at_rest() and (self._is_braking or self.is_at_end() or self._held_s > patience_s)

    def is_at_rest(self) -> bool:
        """Tell whether the references stand still."""
        return self._rate_m_s < AT_REST_M_S

    def is_blocked(self) -> bool:
        """Tell whether something lies in the way just ahead."""
        return self._end_m() < self.plan.trail.length_m and self._end_m() - self.arc_m < LOOKAHEAD_M

    def _next_rate(self, elapsed_s: float, share: float) -> float:
        soon_m = self.arc_m + np.linspace(0.0, self._rate_m_s * elapsed_s, 3)
        most = float(sample(self.plan.speeds_m_s, soon_m).min())
        left_m = max(self._end_m() - self.arc_m, 0.0)
        creep = min(0.01, left_m / elapsed_s) if self.is_near_end() else 0.0
        wanted = 0.0 if self._is_braking else share * max(min(most, math.sqrt(2.0 * ACCELERATION_M_S2 * left_m)), creep)
        least = self._rate_m_s - BRAKING_M_S2 * elapsed_s
        slowed = max(min(wanted, self._rate_m_s + ACCELERATION_M_S2 * elapsed_s), least, 0.0)
        return min(slowed, max(most, creep))  # a new plan may ask for less than can be braked to: its followers would be too fast

    def is_near_end(self) -> bool:
        """Tell whether the trail ends just ahead, and nothing lies before that."""
        return self._end_m() >= self.plan.trail.length_m and self.plan.trail.length_m - self.arc_m < 0.03

    def _end_m(self) -> float:
        """Return the arc length that is not to be passed."""
        until_m = min(self._clear_m, self._meets_m)
        return until_m if until_m >= self.plan.trail.length_m else until_m - STOP_BEFORE_M

    def _patience(self, poses: Mapping[str, Pose2]) -> float:
        """Return the share of its speed that the formation may have, so that nobody is left behind: 1 to 0."""
        references = self.plan.references(self.arc_m, 0.0)
        off_m = {name: math.dist(references[name].arena_from_body[:2], pose[:2]) for name, pose in poses.items() if name in references}
        worst = max(off_m, key=lambda name: off_m[name], default="")
        share = float(np.clip((FAR_M - off_m.get(worst, 0.0)) / (FAR_M - NEAR_M), 0.0, 1.0))
        self.waits_for = worst if share == 0.0 else self._closed_up_on(poses, off_m, references)
        return 0.0 if self.waits_for else share

    def _is_held_up(self, poses: Mapping[str, Pose2]) -> bool:
        """Tell whether the references stand, and whoever they wait for stays where it is: who steps back to look again is still coming."""
        if self.waits_for in poses:
            place_m = poses[self.waits_for][:2]
            if math.dist(place_m, self._waited_at_m) > STILL_M:
                self._waited_at_m = place_m
                return False
        return self.is_at_rest()

    def _closed_up_on(self, poses: Mapping[str, Pose2], off_m: Mapping[str, float], references: Mapping[str, Reference]) -> str:
        """Return who has fallen behind where another one's reference would go on to; nobody, "", where all have room."""
        soon = self.plan.references(self.arc_m + STEP_M, 0.0)
        for other in sorted(off_m):
            least_m = 2.0 * self._body.radius_m + min(BETWEEN_M, LEEWAY * off_m[other])
            for name in references.keys() - {other}:
                ways = references[name], soon[name]
                apart_m, then_m = (math.dist(reference.arena_from_body[:2], poses[other][:2]) for reference in ways)
                if apart_m < least_m and then_m < apart_m - CLOSING * STEP_M:
                    return other
        return ""

    def _mend(self, cost_map: CostMap) -> None:
        """Change the plan where the map, as it is now, asks for that."""
        self._steps += 1
        self._clear_m = self.plan.clear_until_m(self.arc_m, self._body.radius_m, cost_map)
        if self._is_braking:
            return
        if self._clear_m < self.plan.trail.length_m:
            self._avoid(cost_map)
        elif self._steps % REVIEW_EVERY_STEPS == 0 and not self._review(cost_map):
            self._open_up(cost_map)

    def _avoid(self, cost_map: CostMap) -> None:
        """Let followers give way; where the leader itself cannot go on, take another way, or stop while there is room to turn."""
        leader_m = self._clear_until(self.plan, cost_map, robots=1)
        plan = narrowed_anew(self.plan, self.arc_m, self._body, cost_map) if leader_m == math.inf else None
        if plan is None or self._clear_until(plan, cost_map) <= self._clear_m:
            plan = go_on(self.plan, self.arc_m, self.plan.goal_m, self._body, cost_map)
        if plan is not None and self._clear_until(plan, cost_map) > self._clear_m:
            self._take(plan)
            self._clear_m = plan.clear_until_m(self.arc_m, self._body.radius_m, cost_map)
        elif leader_m < self.arc_m + TURNING_M:
            self.brake()

    def _review(self, cost_map: CostMap) -> bool:
        """Take another way where that is much better by now; tell whether that is so."""
        start = int((self.arc_m + LOOKAHEAD_M) / STEP_M) + 1
        ahead_m = self.plan.trail.points_m[start:]
        if len(ahead_m) < 2:
            return False
        berth = berth_of(self._body)
        cost = cost_of_way(cost_map, ahead_m, berth._replace(least_m=berth.least_m - STEP_M))
        best = Reach(cost_map, ahead_m[0], berth).cost_to(ahead_m[-1])
        if best >= WORTH_SHARE * cost or best >= cost - WORTH_M:
            return False
        plan = go_on(self.plan, self.arc_m, self.plan.goal_m, self._body, cost_map)
        if plan is not None:
            self._take(plan)
        return plan is not None

    def _open_up(self, cost_map: CostMap) -> None:
        """Let followers use the room that there is by now, where that brings them well nearer to their open places."""
        if not self.plan.offsets.size:
            return  # nobody follows
        ahead_m = self.arc_m + np.linspace(0.0, OPEN_REACH_M, OPEN_SAMPLES)
        drawn_in_m = self.plan.drawn_in_m(ahead_m).mean()
        if drawn_in_m < OPENING_M:
            return
        plan = narrowed_anew(self.plan, self.arc_m, self._body, cost_map)
        if plan.drawn_in_m(ahead_m).mean() >= drawn_in_m - OPENING_M:
            return
        if self._clear_until(plan, cost_map) == math.inf and meets_from_m(plan, self.arc_m, self._body) >= self._meets_m:
            self._take(plan)

    def _take(self, plan: Plan) -> None:
        self.plan = plan
        self._meets_m = meets_from_m(plan, self.arc_m, self._body)
        self._clear_m = plan.trail.length_m

    def _clear_until(self, plan: Plan, cost_map: CostMap, robots: int | None = None) -> float:
        """Return how far a plan is clear, infinity where it is to its end."""
        until_m = plan.clear_until_m(self.arc_m, self._body.radius_m, cost_map, robots)
        return math.inf if until_m >= plan.trail.length_m else until_m
