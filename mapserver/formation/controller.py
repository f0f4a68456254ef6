"""The formation's step: who is there and what is known goes in, everybody's setpoint and what the formation is doing come out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from mapserver.formation.bumps import Bumps
from mapserver.formation.costmap import CostMap, Disc, cost_map
from mapserver.formation.driving import Driving
from mapserver.formation.follow import TIGHT_SIDE_M, Body
from mapserver.formation.forming import Start, form_up
from mapserver.formation.gathering import Gathering
from mapserver.formation.mission import Exploration, Goal, GoalList, Mission
from mapserver.formation.onward import berth_of
from mapserver.formation.planning import Reach
from mapserver.formation.task import Moment, Task
from mapserver.formation.trail import Reference
from protocol.geometry import Array, Pose2
from protocol.messages import Phase

START_PATIENCE_S = 10.0  # that robots which have not come yet are waited for
LONGEST_STEP_S = 0.5  # of time that counts as driven between two moments
LOST_MARGIN_M = 0.03  # around a robot that nobody hears
OPEN_M = 0.02  # slots so near to the shape's own count as open
RETRY_S = 0.5  # between two attempts to form up
CHANGE_M = 0.5  # of gathering that another leader has to save
SETTLE_S = 0.6  # that robots take to come to rest after their references did


class Orders(NamedTuple):
    """What one step says."""

    references: Mapping[str, Reference]
    phase: Phase
    reason: str = ""
    leader: str = ""
    goal: Goal | None = None
    slots: Mapping[str, tuple[float, float]] = {}


class FormationController:
    """Holds what the formation is at; `step` it with moments in the order of their stamps."""

    def __init__(self, task: Task, radii_m: Mapping[str, float]) -> None:
        """Lead these robots, all of them as wide as the widest."""
        self._task, self._robots = task, frozenset(radii_m)
        self._body = Body(max(radii_m.values()), task.cruise_m_s, task.max_speed_m_s)
        self._mission: Mission = Exploration() if task.explores else GoalList(task.goals)
        self._activity: Gathering | Driving | None = None
        self._stands: dict[str, Reference] = {}  # where all stay while there is no activity
        self._slots: dict[str, tuple[float, float]] = {}
        self._leader = ""
        self._is_led_on = False  # whoever leads goes on to: the way to this goal is not done
        self._bumps = Bumps(self._body.radius_m)
        self._unfit: set[str] = set()  # behind whom the others could not gather
        self._first_ns = self._last_ns = -1
        self._stood_m: Array | None = None  # the trail along which they stand since the last drive
        self._pause_s = 0.0
        self._trouble = ""  # why there is no activity

    def step(self, moment: Moment) -> Orders:
        """Return the orders for a moment."""
        elapsed_s = self._elapsed_s(moment.stamp_ns)
        if (reason := self._reason_to_wait(moment)) is not None:
            return self._at_ease(reason)
        scene = self._scene(moment)
        goal = self._goal(moment, scene)
        self._go_through(elapsed_s, moment, goal, scene)
        return self._orders(elapsed_s, moment, goal, scene)

    def _elapsed_s(self, stamp_ns: int) -> float:
        if self._first_ns < 0:
            self._first_ns = self._last_ns = stamp_ns
        elapsed_s = (stamp_ns - self._last_ns) * 1e-9
        self._last_ns = stamp_ns
        return min(max(elapsed_s, 0.0), LONGEST_STEP_S)

    def _reason_to_wait(self, moment: Moment) -> str | None:
        """Return why nobody is moved now, None where nothing stands against it."""
        absent = sorted(self._robots - moment.poses.keys())
        if moment.stopped:
            return moment.stopped
        if not moment.poses:
            return f"waiting for {', '.join(absent)}"
        is_new = self._activity is None and not self._stands
        if absent and is_new and (moment.stamp_ns - self._first_ns) * 1e-9 < START_PATIENCE_S:
            return f"waiting for {', '.join(absent)}"
        return None

    def _at_ease(self, reason: str) -> Orders:
        """Forget what was under way, and let everybody stand."""
        self._activity, self._stands, self._slots = None, {}, {}
        self._pause_s = 0.0
        return Orders({}, "waiting", reason)

    def _scene(self, moment: Moment) -> CostMap:
        """Return the map to drive on, with what is in the way though it is not mapped: lost robots, and what robots came up against."""
        places_m = np.array([pose[:2] for pose in moment.poses.values()] + [*self._task.goals])
        lost = [Disc(np.array(pose[:2]), self._body.radius_m + LOST_MARGIN_M) for pose in moment.lost.values()]
        mapped = cost_map(moment.floor, self._task.bounds, places_m, moment.moving).with_discs(lost)
        self._bumps.note(moment, self._stands, mapped)
        return mapped.with_discs(self._bumps.things())

    def _goal(self, moment: Moment, scene: CostMap) -> Goal | None:
        leader = self._leader if self._leader in moment.poses else self._first_leader(moment)
        return self._mission.goal(scene, moment.poses[leader], berth_of(self._body))

    def _first_leader(self, moment: Moment) -> str:
        return self._task.leader if self._task.leader in moment.poses else min(moment.poses)

    def _go_through(self, elapsed_s: float, moment: Moment, goal: Goal | None, scene: CostMap) -> None:
        """End what is over, and begin what comes next."""
        self._end_activity(moment, goal, scene)
        if self._activity is None:
            self._pause_s -= elapsed_s
            if goal is not None and self._pause_s <= 0.0:
                self._form_up(moment, goal, scene)

    def _end_activity(self, moment: Moment, goal: Goal | None, scene: CostMap) -> None:
        activity = self._activity
        members_changed = activity is not None and set(activity.plan.names) != set(moment.poses)
        match activity:
            case Gathering():
                if members_changed or activity.plan.goal_m != goal:
                    self._rest("")
                elif activity.has_failed():
                    self._unfit.add(activity.plan.leader)
                    self._rest(f"no way to its slot for {', '.join(activity.missing())}")
                elif activity.is_done():
                    self._unfit.clear()
                    self._activity = Driving(activity.plan, activity.arc_m, activity.body)
            case Driving():
                self._end_drive(activity, members_changed, goal, scene)
            case None:
                pass

    def _end_drive(self, drive: Driving, members_changed: bool, goal: Goal | None, scene: CostMap) -> None:
        self._stood_m = drive.stood_m()
        if drive.has_arrived() and drive.is_at_rest():
            if drive.plan.goal_m == goal:
                self._mission.reached()
            self._rest("")
            self._is_led_on = False
        elif drive.is_over():
            self._rest("")
        elif members_changed or goal is None:
            drive.brake()
        elif drive.plan.goal_m != goal:
            drive.turn_to(goal, scene)

    def _rest(self, trouble: str) -> None:
        """Let everybody stay where its reference is, for a while."""
        self._activity, self._pause_s, self._trouble = None, SETTLE_S, trouble

    def _form_up(self, moment: Moment, goal: Goal, scene: CostMap) -> None:
        """Begin to gather behind the leader that makes least work of it, on a tight way where there is no other."""
        for body in (self._body, replace(self._body, side_m=TIGHT_SIDE_M)):
            best = self._best_start(moment, goal, scene, body)
            if best is not None:
                self._leader, self._trouble, self._stood_m = best.plan.leader, "", None
                self._is_led_on = True
                self._activity = Gathering(best.plan, best.arc_m, moment.poses, body)
                return
        self._mission.give_up()
        self._trouble, self._pause_s = f"no way to ({goal[0]:.2f}, {goal[1]:.2f})", RETRY_S

    def _best_start(self, moment: Moment, goal: Goal, scene: CostMap, body: Body) -> Start | None:
        """Return the start that makes least work, with whoever leads already where that is little; None where there is none."""
        started: list[Start] = []
        from_goal = Reach(scene, np.array(goal), berth_of(body))
        leaders = self._leaders(moment, from_goal)
        for leader in leaders:
            start = form_up(moment.poses, leader, goal, from_goal, self._task.shape, body, scene, self._stood_m)
            started += [] if start is None else [start]
            if start is not None and start.effort_m < CHANGE_M:
                break
        return min(started, key=lambda start: (start.plan.leader in self._unfit, self._effort_m(start, leaders[0])), default=None)

    @staticmethod
    def _effort_m(start: Start, leader: str) -> float:
        return start.effort_m if start.plan.leader == leader else start.effort_m + CHANGE_M

    def _leaders(self, moment: Moment, from_goal: Reach) -> list[str]:
        """Return who may lead: whoever does already, then, so that a dead end can be left, who is nearest to the goal."""
        first = self._leader if self._is_led_on and self._leader in moment.poses else self._first_leader(moment)
        return sorted(sorted(moment.poses), key=lambda name: (name != first, from_goal.cost_to(np.array(moment.poses[name][:2]))))

    def _orders(self, elapsed_s: float, moment: Moment, goal: Goal | None, scene: CostMap) -> Orders:
        activity = self._activity
        if activity is None:
            return self._standing(moment.poses, goal)
        references = activity.step(elapsed_s, moment.poses, scene)
        self._stands = {name: Reference(reference.arena_from_body, 0.0, 0.0) for name, reference in references.items()}
        self._slots = activity.plan.slots(activity.arc_m)
        phase, reason = _named_phase(activity, self._mission)
        present = {name: reference for name, reference in references.items() if name in moment.poses}
        return Orders(present, phase, reason, activity.plan.leader, activity.plan.goal_m, self._present_slots(moment.poses))

    def _standing(self, poses: Mapping[str, Pose2], goal: Goal | None) -> Orders:
        stands = {name: reference for name, reference in self._stands.items() if name in poses}
        phase: Phase = "arrived" if goal is None else "blocked" if self._trouble else "gathering"
        leader = self._leader if self._leader in poses else ""
        return Orders(stands, phase, self._trouble if goal else "", leader, goal, self._present_slots(poses) if leader else {})

    def _present_slots(self, poses: Mapping[str, Pose2]) -> dict[str, tuple[float, float]]:
        return {name: slot for name, slot in self._slots.items() if name in poses}


def _named_phase(activity: Gathering | Driving, mission: Mission) -> tuple[Phase, str]:
    """Return the phase, and for a person what is waited for."""
    if isinstance(activity, Gathering):
        missing = activity.missing()
        return "gathering", f"waiting for {', '.join(missing)} to take its slot" if missing else ""
    if activity.is_at_rest() and activity.waits_for:
        return "blocked", f"waiting for {activity.waits_for}, which is held up"
    if activity.is_at_rest() and activity.is_blocked():
        return "blocked", "something stands in the way"
    if mission.heading != "moving":
        return mission.heading, ""
    return ("moving" if activity.plan.is_steady(activity.arc_m, OPEN_M) else "avoiding"), ""
