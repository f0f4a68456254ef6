"""The driver's seat: from setpoints, poses, wheel readings and local maps to the drive order that is due.

What it orders for a stamp follows from what is known up to that stamp, so that a world that waits for answers is repeatable.
"""

from __future__ import annotations

import math
import time
from collections import Counter
from collections.abc import Callable
from typing import Literal, NamedTuple

from agent.control.course import Course
from agent.control.lane import Lane
from agent.control.limits import DriveLimits, applied
from agent.control.near_things import NearThings
from agent.control.safety import Checked, Keeping, checked
from agent.control.second_look import BEHIND_M, UNSEEN_S, Hold
from agent.control.setpoints import Broadcast, SetpointGate, Standing
from agent.control.tracking import Reference, track
from agent.control.trail import Trail
from agent.control.twist import STANDING, Twist, wheel_speeds
from agent.driving.guard_pipe import ORDER_LIMIT_S, DriveOrder
from agent.rig import Body
from agent.slam.odometry import WheelGeometry
from agent.wheel_history import WheelHistory
from protocol.geometry import Array, Pose2
from protocol.messages import LocalMap, Poses, Setpoints

BLIND_S = 0.5  # with an older picture, or older wheel readings, the robot stands
POSES_LIMIT_S = 0.05  # for how long setpoints wait for the poses of their stamp, which may come on the link just behind them
_MOST_ELAPSED_S = 0.2  # by which a single order may change the speeds

NO_POSE = "no pose from the map server"

Drive = Literal["standing", "driving", "slowed", "blocked"]


class Decision(NamedTuple):
    """How the robot is to move, and why not otherwise; the reason is one line for a person, and empty where there is nothing to say."""

    twist: Twist
    drive: Drive
    reason: str


class _Done(NamedTuple):
    """What was ordered at a stamp, and what then held the robot up."""

    stamp_ns: int
    twist: Twist
    hold: Hold


class DriverSeat:
    """Drives one robot. `now_ns` is the map server's clock, None while it is not known; `clock_s` is monotonic."""

    def __init__(
        self,
        robot: str,
        body: Body,
        limits: DriveLimits,
        margin_m: float,
        history: WheelHistory,
        now_ns: Callable[[], int | None],
        clock_s: Callable[[], float] = time.monotonic,
    ) -> None:
        self._robot, self._limits, self._history = robot, limits, history
        self._now_ns, self._clock_s = now_ns, clock_s
        self._wheels = WheelGeometry(body.wheel_radius_m, body.wheel_base_m)
        self._keeping = Keeping(body.body_radius_m, margin_m, limits.max_speed_m_s)
        self._course, self._gate, self._near = Course(self._wheels), SetpointGate(robot, limits), NearThings(body.body_radius_m)
        self._trail, self._lane = Trail(), Lane()
        self._seen_ns: int | None = None  # the last usable picture
        self._poses_ns = -1  # the last poses
        self._decided: tuple[int, int, int] | None = None  # epoch and seq of the setpoints, and the stamp of the robot's pose
        self._decision = Decision(STANDING, "standing", "")
        self._now_done = _Done(-1, STANDING, Hold())  # at the pose's stamp
        self._last_done = _Done(-1, STANDING, Hold())  # at an earlier one

    @property
    def counts(self) -> Counter[str]:
        """How many broadcasts were refused, by reason."""
        return self._gate.counts

    def see(self, local_map: LocalMap, angles_rad: Array) -> None:
        """Take the newest local map, made with the wheels at (2,) [rad]."""
        self._course.note_frame(local_map.stamp_ns, angles_rad, Pose2(*local_map.odom_from_body))
        self._near.see(local_map)
        self._trail.note(Pose2(*local_map.odom_from_body))
        if local_map.picture == "used":
            self._seen_ns = local_map.stamp_ns

    def locate(self, poses: Poses) -> None:
        """Take the map server's poses. One that is only predicted says no more than the robot's own odometry does."""
        self._poses_ns = max(self._poses_ns, poses.stamp_ns)
        measured = {pose.robot: Pose2(*pose.arena_from_body) for pose in poses.robots if not pose.predicted}
        if self._robot in measured:
            self._course.note_pose(poses.stamp_ns, self._history.angles_at(poses.stamp_ns), measured[self._robot])
        odom_from_arena = self._course.odom_from_arena()
        if odom_from_arena is not None:
            places_m = {robot: odom_from_arena.apply(pose[:2]) for robot, pose in measured.items()}
            self._near.note_robots(poses.stamp_ns, self._robot, places_m)

    def offer(self, setpoints: Setpoints, arrived_s: float) -> None:
        """Take a broadcast that arrived at a time on the monotonic clock."""
        self._gate.offer(setpoints, arrived_s)

    def order(self) -> DriveOrder | None:
        """Return the drive order that is due: one for each broadcast, and one for each wheel reading as long as that broadcast counts."""
        broadcast = self._gate.newest
        if broadcast is None or not self._is_due(broadcast):
            return None
        self._decided = self._occasion(broadcast)
        left_s = broadcast.left_s(self._clock_s())
        if left_s <= 0.0:
            return None  # the wheel guard has stopped the wheels
        self._decision = self._decide(broadcast)
        left, right = wheel_speeds(self._decision.twist, self._wheels)
        return DriveOrder(left_rad_s=left, right_rad_s=right, valid_s=min(left_s, ORDER_LIMIT_S), answers_ns=broadcast.stamp_ns)

    def fares(self) -> Decision:
        """Return how the robot is being driven."""
        broadcast = self._gate.newest
        if broadcast is None:
            return Decision(STANDING, "standing", "")
        if broadcast.left_s(self._clock_s()) <= 0.0:
            return Decision(STANDING, "standing", f"no setpoints for {self._clock_s() - broadcast.arrived_s:.1f} s: standing")
        return self._decision

    def _occasion(self, broadcast: Broadcast) -> tuple[int, int, int]:
        return broadcast.message.epoch, broadcast.message.seq, self._history.until_ns

    def _is_due(self, broadcast: Broadcast) -> bool:
        if self._decided == self._occasion(broadcast):
            return False
        if self._decided is not None and self._decided[:2] == (broadcast.message.epoch, broadcast.message.seq):
            return broadcast.own is not None
        return self._poses_ns >= broadcast.stamp_ns or self._clock_s() - broadcast.arrived_s >= POSES_LIMIT_S

    def _decide(self, broadcast: Broadcast) -> Decision:
        """Return what to do about a broadcast with the robot where the newest wheel readings say that it is."""
        pose_ns = self._history.until_ns
        odom_from_body = self._course.odom_from_body(pose_ns, self._history.angles_at(pose_ns))
        arena_from_body = None if odom_from_body is None else self._course.arena_from_body(odom_from_body)
        if odom_from_body is None or arena_from_body is None:
            return self._stand(pose_ns, NO_POSE)
        found = self._gate.reference(self._now_ns(), arena_from_body)
        if isinstance(found, Standing):
            return self._stand(pose_ns, found.reason)
        if blindness := self._blindness(pose_ns):
            return self._stand(pose_ns, blindness)
        self._lane.note(broadcast.stamp_ns, found.arena_from_body)
        return self._drive(found.later(1e-9 * (pose_ns - broadcast.stamp_ns)), pose_ns, odom_from_body, arena_from_body)

    def _drive(self, reference: Reference, pose_ns: int, odom_from_body: Pose2, arena_from_body: Pose2) -> Decision:
        """Return the twist towards a reference, or back for a second look, as far as limits and the things around allow it."""
        done = self._done_before(pose_ns)
        elapsed_s = min(1e-9 * (pose_ns - done.stamp_ns), _MOST_ELAPSED_S)
        body_from_reference = arena_from_body.between(reference.arena_from_body)
        around = self._near.around(odom_from_body)
        if done.hold.steps_back:
            wanted = track(odom_from_body.between(self._trail.back(odom_from_body)), STANDING)
            around = around.joined(self._near.robots(odom_from_body))  # one close behind may be hidden as well
        else:
            followed = self._lane.reference(reference, arena_from_body)
            wanted = track(arena_from_body.between(followed.arena_from_body), followed.twist)
        wanted = applied(wanted, done.twist, elapsed_s, self._limits)
        safe = checked(wanted, around, self._keeping)
        is_behind = math.hypot(body_from_reference.x_m, body_from_reference.y_m) >= BEHIND_M
        is_held = safe.blocked and is_behind and not self._is_in_view(wanted, pose_ns, odom_from_body)
        hold = done.hold.after(elapsed_s, odom_from_body, blocked=safe.blocked, held=is_held)
        self._now_done = _Done(pose_ns, safe.twist, hold)
        return _decision(safe, done.hold.steps_back)

    def _is_in_view(self, wanted: Twist, pose_ns: int, odom_from_body: Pose2) -> bool:
        """Tell whether what the robot sees would block it by itself."""
        seen = self._near.around(odom_from_body, since_ns=pose_ns - round(1e9 * UNSEEN_S))
        return checked(wanted, seen, self._keeping).blocked

    def _stand(self, pose_ns: int, reason: str) -> Decision:
        self._done_before(pose_ns)
        self._now_done = _Done(pose_ns, STANDING, Hold())
        return Decision(STANDING, "standing", f"{reason}: standing")

    def _done_before(self, pose_ns: int) -> _Done:
        """Return what was last done at an earlier stamp: an order for the same stamp replaces another, and does not follow it."""
        if self._now_done.stamp_ns < pose_ns:
            self._last_done = self._now_done
        return self._last_done

    def _blindness(self, pose_ns: int) -> str:
        """Return what the robot has not sensed for too long, or nothing."""
        now_ns = max(self._now_ns() or 0, pose_ns)
        if self._seen_ns is None:
            return "no usable picture yet"
        unseen_s, unread_s = 1e-9 * (now_ns - self._seen_ns), 1e-9 * (now_ns - pose_ns)
        if unseen_s > BLIND_S:
            return f"no usable picture for {unseen_s:.1f} s"
        return f"no wheel readings for {unread_s:.1f} s" if unread_s > BLIND_S else ""


def _decision(safe: Checked, steps_back: bool) -> Decision:
    """Return what is to be said of a twist that the local guard has let through."""
    if steps_back:
        return Decision(safe.twist, "slowed", "stepping back to see what is in the way")
    if safe.blocked:
        return Decision(safe.twist, "blocked", "something is in the way")
    return Decision(safe.twist, "slowed" if safe.slowed else "standing" if safe.twist == STANDING else "driving", "")
