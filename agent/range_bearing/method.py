"""From speeds and sightings to local maps: what was seen since the last one is carried to the stamp of the next. Pure."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from agent.range_bearing.dead_reckoning import DeadReckoning, MotionNoise, Odometer, motion_covariance
from protocol.fields import covariance_tuple, pose_tuple
from protocol.geometry import Array, Pose2
from protocol.messages import Identity, LocalMap, SensorReadings, Sighting

MAX_SIGHTINGS = 64  # of one local map


@dataclass(frozen=True)
class SightingNoise:
    """What the sensor errs by, and how fast another robot may have driven since it was seen."""

    range_m: float
    range_share: float
    bearing_rad: float
    target_m_s: float

    def covariance(self, range_m: float) -> Array:
        """Return the covariance of (range, bearing), shape (2, 2) [m^2, m rad, rad^2]."""
        return np.diag([self.range_m**2 + (self.range_share * range_m) ** 2, self.bearing_rad**2])


class _Seen(NamedTuple):
    """One reading of the sensor."""

    stamp_ns: int
    range_m: float
    bearing_rad: float
    identity: Identity


class RangeBearingMethod:
    """Holds one robot's dead reckoning; `step` returns one local map for each message of readings."""

    def __init__(self, robot: str, epoch: int, body_radius_m: float, response_s: float, motion: MotionNoise, sight: SightingNoise) -> None:
        self._robot, self._epoch, self._body_radius_m = robot, epoch, body_radius_m
        self._motion, self._sight = motion, sight
        self._steady = replace(motion, walk_m_sqrt_s=0.0, walk_rad_sqrt_s=0.0)  # a drift that tells over seconds hardly does within a step
        self._reckoning = DeadReckoning(response_s)
        self._last: Odometer | None = None
        self._seq = 0

    def step(self, readings: SensorReadings) -> LocalMap:
        """Return what is known at the stamp up to which the readings are complete."""
        twists = zip(readings.twist_stamps_ns.array().tolist(), readings.twists.array().tolist(), strict=True)
        for stamp_ns, (forward_m_s, turn_rad_s) in twists:
            self._reckoning.add(stamp_ns, forward_m_s, turn_rad_s)
        now = self._reckoning.at(readings.until_ns)
        last = self._last or now
        local_map = LocalMap(
            robot=self._robot,
            epoch=self._epoch,
            seq=self._seq,
            stamp_ns=readings.until_ns,
            picture="used",
            odom_from_body=pose_tuple(now.odom_from_body),
            previous_from_body=pose_tuple(last.odom_from_body.between(now.odom_from_body)),
            motion_covariance=covariance_tuple(motion_covariance(last, now, self._motion)),
            floor_range_m=0.0,
            body_radius_m=self._body_radius_m,
            camera_height_m=1.0,
            regions=(),
            sightings=tuple(self._carried(seen, readings.until_ns, now) for seen in _seen(readings)[-MAX_SIGHTINGS:]),
        )
        self._last, self._seq = now, self._seq + 1
        self._reckoning.forget_before(readings.until_ns)
        return local_map

    def _carried(self, seen: _Seen, stamp_ns: int, now: Odometer) -> Sighting:
        """Return a sighting as it is from where the robot stands now: the robot has driven on, and so may what it saw."""
        then = self._reckoning.at(seen.stamp_ns)
        point_then = seen.range_m * np.array([math.cos(seen.bearing_rad), math.sin(seen.bearing_rad)])
        body_from_then = now.odom_from_body.between(then.odom_from_body)
        point = body_from_then.apply(point_then)
        covariance = _in_cartesian(self._sight.covariance(seen.range_m), point_then, body_from_then)
        covariance += _moved_by(motion_covariance(then, now, self._steady), point)
        if seen.identity.kind == "robot":
            covariance += (self._sight.target_m_s * (stamp_ns - seen.stamp_ns) * 1e-9) ** 2 * np.eye(2)
        return _sighting(point, covariance, seen.identity)


def _seen(readings: SensorReadings) -> Sequence[_Seen]:
    """Return the sightings of a message; what is at no distance shows nothing."""
    stamps, pairs = readings.sighting_stamps_ns.array().tolist(), readings.sightings.array().tolist()
    rows = zip(stamps, pairs, readings.identities, strict=True)
    return [_Seen(stamp_ns, range_m, bearing, identity) for stamp_ns, (range_m, bearing), identity in rows if range_m > 0.0]


def _in_cartesian(polar: Array, point_then: Array, body_from_then: Pose2) -> Array:
    """Return a covariance of (range, bearing) at a point as one of (x, y) [m^2; body], both shape (2, 2)."""
    radial = point_then / np.hypot(*point_then)
    jacobian = body_from_then.rotation() @ np.column_stack([radial, [-point_then[1], point_then[0]]])
    return np.asarray(jacobian @ polar @ jacobian.T)


def _moved_by(motion: Array, point: Array) -> Array:
    """Return the covariance, shape (2, 2) [m^2; body], that a motion's, shape (3, 3), gives to a point that stood still meanwhile."""
    jacobian = np.array([[1.0, 0.0, -point[1]], [0.0, 1.0, point[0]]])
    return np.asarray(jacobian @ motion @ jacobian.T)


def _sighting(point: Array, covariance: Array, identity: Identity) -> Sighting:
    """Return a point, shape (2,) [m; body], with its covariance, shape (2, 2), as a sighting."""
    range_m = max(float(np.hypot(*point)), 1e-3)
    to_polar = np.array([point / range_m, np.array([-point[1], point[0]]) / range_m**2])
    polar = to_polar @ covariance @ to_polar.T
    stated = (float(polar[0, 0]), float(polar[0, 1]), float(polar[1, 1]))
    return Sighting(range_m=range_m, bearing_rad=math.atan2(point[1], point[0]), covariance=stated, identity=identity)
