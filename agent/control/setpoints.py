"""Which setpoint counts: broadcasts have to come in order, in time and within what the robot can do."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass
from typing import NamedTuple

from agent.control.limits import DriveLimits
from agent.control.tracking import Reference
from agent.control.twist import Twist
from protocol.geometry import Pose2
from protocol.messages import Setpoint, Setpoints

FRESH_S = 0.45  # after its reception a broadcast counts for so long: half a second, less what link and wheel guard need to stop the wheels
FARTHEST_M = 2.0  # a setpoint farther from the robot is none that it was meant to drive to

OLD_EPOCH = "setpoints: older epoch"
DUPLICATE = "setpoints: duplicate"
OUT_OF_ORDER = "setpoints: out of order"
EXPIRED = "setpoints: no longer valid"
NO_CLOCK = "setpoints: server's clock unknown"
TOO_FAST = "setpoint: out of limits"
TOO_FAR = "setpoint: too far away"

NO_SETPOINT = "no setpoint for this robot"


@dataclass(frozen=True)
class Broadcast:
    """A broadcast as one robot heard it."""

    message: Setpoints
    own: Setpoint | None  # None: this robot has to stand
    arrived_s: float  # monotonic

    @property
    def stamp_ns(self) -> int:
        """Return when the setpoints hold."""
        return self.message.stamp_ns

    def left_s(self, now_s: float) -> float:
        """Return for how much longer it counts, which is not above zero once it no longer does."""
        return self.arrived_s + FRESH_S - now_s


class Standing(NamedTuple):
    """Why there is nothing to be followed."""

    reason: str


class SetpointGate:
    """Lets one robot's setpoints through; `counts` tells, by reason, how many broadcasts were refused."""

    def __init__(self, robot: str, limits: DriveLimits) -> None:
        self._robot, self._limits = robot, limits
        self._newest: Broadcast | None = None
        self._refused: tuple[int, int] | None = None  # the broadcast last counted as refused, so that none counts twice
        self.counts: Counter[str] = Counter()

    @property
    def newest(self) -> Broadcast | None:
        """The newest broadcast that came in order."""
        return self._newest

    def offer(self, message: Setpoints, arrived_s: float) -> None:
        """Take a broadcast if it comes in order. A map server that was started anew has a higher epoch, and counts from zero."""
        reason = None if self._newest is None else _disorder(self._newest.message, message)
        if reason is not None:
            self.counts[reason] += 1
            return
        own = next((setpoint for setpoint in message.robots if setpoint.robot == self._robot), None)
        self._newest = Broadcast(message, own, arrived_s)

    def reference(self, now_ns: int | None, arena_from_body: Pose2) -> Reference | Standing:
        """Return what the newest broadcast wants followed, at its own stamp.

        `now_ns` is the map server's clock, None where it is not known; `arena_from_body` is where the robot is.
        """
        if self._newest is None or self._newest.own is None:
            return Standing(NO_SETPOINT)
        fault = self._fault(self._newest.message, self._newest.own, now_ns, arena_from_body)
        if fault is not None:
            self._count(fault, self._newest.message)
            return Standing(fault)
        own = self._newest.own
        return Reference(Pose2(*own.arena_from_body), Twist(own.speed_m_s, own.turn_rad_s))

    def _fault(self, message: Setpoints, own: Setpoint, now_ns: int | None, arena_from_body: Pose2) -> str | None:
        if now_ns is None:
            return NO_CLOCK
        if now_ns > message.valid_until_ns:
            return EXPIRED
        if abs(own.speed_m_s) > self._limits.max_speed_m_s or abs(own.turn_rad_s) > self._limits.max_turn_rad_s:
            return TOO_FAST
        x_m, y_m, _ = own.arena_from_body
        return TOO_FAR if math.hypot(x_m - arena_from_body.x_m, y_m - arena_from_body.y_m) > FARTHEST_M else None

    def _count(self, reason: str, message: Setpoints) -> None:
        if self._refused != (message.epoch, message.seq):
            self._refused = (message.epoch, message.seq)
            self.counts[reason] += 1


def _disorder(last: Setpoints, message: Setpoints) -> str | None:
    """Return why a broadcast cannot follow the last one, or None where it can."""
    if message.epoch != last.epoch:
        return OLD_EPOCH if message.epoch < last.epoch else None
    if message.seq == last.seq:
        return DUPLICATE
    return OUT_OF_ORDER if message.seq < last.seq or message.stamp_ns < last.stamp_ns else None
