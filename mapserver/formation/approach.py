"""One robot's own way to its slot: it turns on the spot, drives, and turns again, while the formation stands."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from mapserver.formation.costmap import CostMap, Disc
from mapserver.formation.follow import LEAST_SIDE_M
from mapserver.formation.planning import Berth, Reach
from mapserver.formation.smoothing import smooth
from mapserver.formation.speeds import stoppable
from mapserver.formation.trail import STEP_M, Lane, Reference, resampled, sample
from protocol.geometry import Array, Pose2, wrap_angle

HELD_M, HELD_RAD = 0.02, 0.08  # so near to its slot a robot holds it
SHORT_M = 0.12  # a way so short is driven straight
MARGIN_M, WISHED_M = 0.03, 0.12
BETWEEN_M = 0.065  # between the bodies of two robots
CRUISE_M_S, MOST_TURN_RAD_S = 0.15, 1.2
TURN_ACCELERATION_RAD_S2 = 2.5
AWAY_M, AWAY_RAD = 0.08, 0.4  # a robot that is further from its reference is waited for
DONE_RAD = 0.005


class Turn:
    """A turn on the spot by the shorter side; `advance` it, then read `reference`."""

    def __init__(self, start: Pose2, heading_rad: float) -> None:
        """Turn from a pose to a heading [arena]."""
        self._pose = start
        self._left_rad = wrap_angle(heading_rad - start.theta_rad)
        self._rate_rad_s = 0.0

    def advance(self, elapsed_s: float) -> None:
        """Go on for so long."""
        most = min(MOST_TURN_RAD_S, math.sqrt(2.0 * TURN_ACCELERATION_RAD_S2 * abs(self._left_rad)))
        rate = min(abs(self._rate_rad_s) + TURN_ACCELERATION_RAD_S2 * elapsed_s, most)
        step_rad = math.copysign(min(rate * elapsed_s, abs(self._left_rad)), self._left_rad)
        self._pose = self._pose @ Pose2(0.0, 0.0, step_rad)
        self._left_rad -= step_rad
        self._rate_rad_s = 0.0 if self.is_done() else math.copysign(rate, self._left_rad)

    def is_done(self) -> bool:
        """Tell whether the heading is reached."""
        return abs(self._left_rad) < DONE_RAD

    def reference(self) -> Reference:
        """Return where the robot should be now."""
        return Reference(self._pose, 0.0, self._rate_rad_s)


class Drive:
    """A drive along a curve, from rest to rest."""

    def __init__(self, lane: Lane) -> None:
        """Begin at the lane's first sample."""
        self._lane = lane
        limits = np.minimum(CRUISE_M_S, MOST_TURN_RAD_S / np.maximum(np.abs(lane.turns), 1e-6))
        limits[-1] = 0.0
        self._speeds_m_s = stoppable(limits)
        self._arc_m, self._rate_m_s = 0.0, 0.0

    def advance(self, elapsed_s: float) -> None:
        """Go on for so long."""
        most = max(float(sample(self._speeds_m_s, self._arc_m)), 0.01)
        self._rate_m_s = min(self._rate_m_s + 0.12 * elapsed_s, most)
        self._arc_m = min(self._arc_m + self._rate_m_s * elapsed_s, self._lane.length_m)
        if self.is_done():
            self._rate_m_s = 0.0

    def is_done(self) -> bool:
        """Tell whether the end is reached."""
        return self._arc_m >= self._lane.length_m

    def left_m(self) -> Array:
        """Return the places still ahead, shape (n, 2) [arena]."""
        return self._lane.points_m[int(self._arc_m / STEP_M) :]

    def end(self) -> Pose2:
        """Return the pose at the end."""
        return self._lane.at(self._lane.length_m, 0.0).arena_from_body

    def reference(self) -> Reference:
        """Return where the robot should be now."""
        return self._lane.at(self._arc_m, self._rate_m_s)


class Approach:
    """The stages of one robot's way, and how far it is."""

    def __init__(self, start: Pose2, slot: Pose2, lane: Lane | None) -> None:
        """Drive from `start` along `lane` to `slot`; without a lane only turn there."""
        self.slot, self.lane = slot, lane
        if lane is None:
            self._stages: list[Turn | Drive] = [Turn(start, slot.theta_rad)]
        else:
            drive = Drive(lane)
            self._stages = [Turn(start, float(lane.headings_rad[0])), drive, Turn(drive.end(), slot.theta_rad)]
        self._now = 0
        self.waited_s = 0.0  # for the robot, which has been too far behind for so long

    def advance(self, elapsed_s: float, pose: Pose2) -> Reference:
        """Go on, unless the robot is too far behind, and return where it should be now."""
        behind = self.reference().arena_from_body.between(pose)
        if math.hypot(behind.x_m, behind.y_m) > AWAY_M or abs(behind.theta_rad) > AWAY_RAD:
            self.waited_s += elapsed_s
            return self.reference()._replace(speed_m_s=0.0, turn_rad_s=0.0)
        self.waited_s = 0.0
        while self._stages[self._now].is_done() and self._now + 1 < len(self._stages):
            self._now += 1
        self._stages[self._now].advance(elapsed_s)
        return self.reference()

    def reference(self) -> Reference:
        """Return where the robot should be now."""
        return self._stages[self._now].reference()

    def is_done(self) -> bool:
        """Tell whether the robot's reference has come to its slot."""
        return self._now + 1 == len(self._stages) and self._stages[self._now].is_done()

    def is_clear(self, cost_map: CostMap, radius_m: float) -> bool:
        """Tell whether nothing has turned up on what is left of the way; who is nearer to something already may leave it."""
        stage = self._stages[self._now]
        return not isinstance(stage, Drive) or not cost_map.too_near(stage.left_m(), radius_m + LEAST_SIDE_M).any()

    def way_m(self) -> Array:
        """Return the places that it leads over, shape (n, 2) [arena]."""
        return np.array([self.slot[:2]]) if self.lane is None else self.lane.points_m


def holds(pose: Pose2, slot: Pose2) -> bool:
    """Tell whether a robot is so near to its slot that it needs no way of its own."""
    off = slot.between(pose)
    return math.hypot(off.x_m, off.y_m) <= HELD_M and abs(off.theta_rad) <= HELD_RAD


def bodies_of(poses: Mapping[str, Pose2], besides: str, radius_m: float) -> list[Disc]:
    """Return all robots but one as things in the way."""
    return [Disc(np.array(pose[:2]), radius_m) for name, pose in poses.items() if name != besides]


def approach(start: Pose2, slot: Pose2, others: list[Disc], radius_m: float, cost_map: CostMap) -> Approach | None:
    """Return a way to a slot past other robots, or None where there is none now."""
    start_m, end_m = np.array(start[:2]), np.array(slot[:2])
    if math.dist(start_m, end_m) <= HELD_M:
        return Approach(start, slot, None)
    crowded = cost_map.with_discs([Disc(disc.centre_m, disc.radius_m + BETWEEN_M - MARGIN_M) for disc in others])
    straight_m = resampled(np.vstack([start_m, end_m]), 0.01)
    if len(straight_m) > 2 and crowded.clearance_m(straight_m[2:]).min() >= radius_m + MARGIN_M:
        return Approach(start, slot, Lane.through(straight_m))
    if math.dist(start_m, end_m) < SHORT_M:
        return None
    berth = Berth(radius_m + MARGIN_M, radius_m + WISHED_M, unknown_cost=math.inf)
    route_m = Reach(crowded, start_m, berth).route(end_m)
    if route_m is None or math.dist(route_m[-1], end_m) > HELD_M:
        return None
    way_m = np.vstack([start_m, smooth(route_m, start_m[None], crowded, berth)])
    return Approach(start, slot, Lane.through(way_m))


def keeps_clear(way_m: Array, others_m: Array, apart_m: float) -> bool:
    """Tell whether a way, shape (n, 2), keeps `apart_m` from all of the places, shape (m, 2)."""
    if len(others_m) == 0:
        return True
    return bool(np.hypot(*(way_m[:, None, :] - others_m[None]).transpose(2, 0, 1)).min() >= apart_m)
