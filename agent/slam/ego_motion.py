"""The agent's own pose: wheels for the prediction, the floor's texture for the correction, keyframes against drift."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from agent.slam.floor_motion import Keyframe, align, make_keyframe
from agent.slam.odometry import WheelGeometry, WheelNoise, arc_motion, motion_covariance
from agent.vision.floor_patch import Field, FloorPatch
from protocol.geometry import Array, Pose2

KEYFRAME_DISTANCE_IN_REACHES = 0.33  # of the patch: farther away too little of the same floor is in view
KEYFRAME_TURN_RAD = 0.5
WEAK_CORRELATION = 0.5  # still agreeing, but a fresh keyframe will do better


@dataclass(frozen=True, eq=False)
class Motion:
    """One step of the robot."""

    odom_from_body: Pose2
    previous_from_body: Pose2
    covariance: Array  # (3, 3) of previous_from_body [m, m, rad; body]
    from_floor: bool  # False: by wheels alone


class EgoMotion:
    """Follows the robot from frame to frame. Pure: the same inputs in the same order give the same poses."""

    def __init__(self, patch: FloorPatch, wheels: WheelGeometry, noise: WheelNoise) -> None:
        self._patch = patch
        self._wheels = wheels
        self._noise = noise
        self._angles_rad: Array | None = None
        self._keyframe: Keyframe | None = None
        self._odom_from_keyframe = Pose2.identity()
        self._odom_from_body = Pose2.identity()

    def predict(self, angles_rad: Array) -> tuple[Pose2, Array]:
        """Return previous_from_body and its covariance by the wheels alone, for cumulative wheel angles (2,) [rad] at the new frame."""
        turned = np.zeros(2) if self._angles_rad is None else angles_rad - self._angles_rad
        return arc_motion(turned, self._wheels), motion_covariance(turned, self._wheels, self._noise)

    def advance_blind(self, angles_rad: Array) -> Motion:
        """Take one step without a picture."""
        motion, covariance = self.predict(angles_rad)
        return self._accept(angles_rad, self._odom_from_body @ motion, covariance, from_floor=False)

    def advance(self, angles_rad: Array, cells: Field, bare: NDArray[np.bool_]) -> Motion:
        """Take one step with the newest floor patch, (size, size), and where it shows bare floor."""
        wheel_motion, wheel_covariance = self.predict(angles_rad)
        predicted = self._odom_from_keyframe.between(self._odom_from_body @ wheel_motion)
        found = None if self._keyframe is None else align(self._keyframe, cells, bare, predicted, wheel_covariance)
        if found is None:
            motion = self._accept(angles_rad, self._odom_from_keyframe @ predicted, wheel_covariance, from_floor=False)
        else:
            motion = self._accept(angles_rad, self._odom_from_keyframe @ found.keyframe_from_body, found.covariance, from_floor=True)
        if found is None or found.correlation < WEAK_CORRELATION or self._left_keyframe():
            self._keyframe = make_keyframe(self._patch, cells, bare)
            self._odom_from_keyframe = self._odom_from_body
        return motion

    def _accept(self, angles_rad: Array, odom_from_body: Pose2, covariance: Array, *, from_floor: bool) -> Motion:
        previous = self._odom_from_body
        self._angles_rad, self._odom_from_body = angles_rad, odom_from_body
        return Motion(odom_from_body, previous.between(odom_from_body), covariance, from_floor)

    def _left_keyframe(self) -> bool:
        way = self._odom_from_keyframe.between(self._odom_from_body)
        far = np.hypot(way.x_m, way.y_m) > KEYFRAME_DISTANCE_IN_REACHES * self._patch.reach_m
        return bool(far) or abs(way.theta_rad) > KEYFRAME_TURN_RAD
