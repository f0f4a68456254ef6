"""The agent's own pose: wheels for the prediction, the floor's texture for the correction, keyframes against drift."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from agent.slam.floor_motion import Alignment, Glance, Keyframe, align, make_keyframe
from agent.slam.lifting import LiftWatch
from agent.slam.odometry import WheelGeometry, WheelNoise, arc_motion, motion_covariance, travel
from agent.slam.wheel_path import WheelPath
from agent.vision.floor_patch import Field, FloorPatch
from agent.vision.shutter import RollingShutter
from agent.wheel_history import WheelState
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
    lifts: int = 0  # so often the robot has been lifted and put down elsewhere since it was started
    in_doubt: bool = False  # whether it may be so just now


@dataclass(frozen=True, eq=False)
class Pair:
    """The newest picture beside the keyframe that it was aligned with."""

    keyframe: Keyframe
    glance: Glance
    keyframe_from_body: Pose2
    path: WheelPath


class EgoMotion:
    """Follows the robot from frame to frame. Pure: the same inputs in the same order give the same poses."""

    def __init__(self, patch: FloorPatch, shutter: RollingShutter, wheels: WheelGeometry, noise: WheelNoise) -> None:
        self._patch, self._shutter, self._wheels = patch, shutter, wheels
        self._noise = noise
        self._wheels_then: WheelState | None = None
        self._keyframe: Keyframe | None = None
        self._since_keyframe: list[WheelState] = []
        self._odom_from_keyframe = Pose2.identity()
        self._odom_from_body = Pose2.identity()
        self._lifting = LiftWatch(KEYFRAME_DISTANCE_IN_REACHES * patch.reach_m)
        self.pair: Pair | None = None  # of the last step, where the floor told the motion
        self.glance: Glance | None = None  # of the last step, if that had a picture
        self.begun: Keyframe | None = None  # with the last step's picture

    def refit(self, patch: FloorPatch, shutter: RollingShutter, wheels: WheelGeometry, later_s: float) -> None:
        """Go on with a rig that is known better, and whose wheels are read for a moment that is later by so much."""
        self._patch, self._shutter, self._wheels = patch, shutter, wheels
        self._keyframe, self._since_keyframe, self.pair = None, [], None
        self._lifting.forget()
        if self._wheels_then is not None:
            angles_rad, speeds_rad_s = self._wheels_then
            self._wheels_then = WheelState(angles_rad + later_s * speeds_rad_s, speeds_rad_s)
            self._since_keyframe.append(self._wheels_then)

    def look_back(self, cells: Field, bare: NDArray[np.bool_]) -> None:
        """Make the last picture the keyframe, as it looks with the rig as it is known now: its patch, and where that shows bare floor."""
        if self._wheels_then is not None:
            self._begin_keyframe(self._glance(self._wheels_then, cells, bare))

    def predict(self, wheels: WheelState) -> tuple[Pose2, Array]:
        """Return previous_from_body and its covariance by the wheels alone, for the wheels at the new frame."""
        turned = np.zeros(2) if self._wheels_then is None else wheels.angles_rad - self._wheels_then.angles_rad
        return arc_motion(turned, self._wheels), motion_covariance(turned, self._wheels, self._noise)

    def advance_blind(self, wheels: WheelState) -> Motion:
        """Take one step without a picture."""
        motion, covariance = self.predict(wheels)
        self.pair, self.glance, self.begun = None, None, None
        self._lifting.move(motion)
        return self._accept(wheels, self._odom_from_body @ motion, covariance, from_floor=False)

    def advance(self, wheels: WheelState, cells: Field, bare: NDArray[np.bool_]) -> Motion:
        """Take one step with the newest floor patch, (size, size), and where it shows bare floor."""
        wheel_motion, wheel_covariance = self.predict(wheels)
        glance = self._glance(wheels, cells, bare)
        self.glance, self.begun = glance, None
        predicted = self._odom_from_keyframe.between(self._odom_from_body @ wheel_motion)
        found = None if self._keyframe is None else align(self._keyframe, glance, predicted, wheel_covariance)
        self._watch_floor(glance, wheel_motion, predicted, found)
        if self._keyframe is None or found is None:
            motion = self._accept(wheels, self._odom_from_keyframe @ predicted, wheel_covariance, from_floor=False)
            self.pair = None
        else:
            motion = self._accept(wheels, self._odom_from_keyframe @ found.keyframe_from_body, found.covariance, from_floor=True)
            self.pair = Pair(self._keyframe, glance, found.keyframe_from_body, WheelPath.through(self._since_keyframe, self._wheels))
        if found is None or found.correlation < WEAK_CORRELATION or self._left_keyframe():
            self._begin_keyframe(glance)
            self.begun = self._keyframe
        return motion

    def _glance(self, wheels: WheelState, cells: Field, bare: NDArray[np.bool_]) -> Glance:
        return Glance(cells, bare, self._shutter, *travel(wheels.speeds_rad_s, self._wheels))

    def _watch_floor(self, glance: Glance, wheel_motion: Pose2, predicted: Pose2, found: Alignment | None) -> None:
        """Watch for the robot being lifted: by what the wheels say, where the body should be in the keyframe, and where it was found."""
        self._lifting.move(wheel_motion)
        if found is not None:
            self._lifting.agree(glance)
        elif self._keyframe is not None:
            self._lifting.disagree(self._keyframe, predicted)

    def _begin_keyframe(self, glance: Glance) -> None:
        self._keyframe = make_keyframe(self._patch, glance)
        self._odom_from_keyframe, self._since_keyframe = self._odom_from_body, self._since_keyframe[-1:]

    def _accept(self, wheels: WheelState, odom_from_body: Pose2, covariance: Array, *, from_floor: bool) -> Motion:
        previous = self._odom_from_body
        self._wheels_then, self._odom_from_body = wheels, odom_from_body
        self._since_keyframe.append(wheels)
        way = previous.between(odom_from_body)
        return Motion(odom_from_body, way, covariance, from_floor, self._lifting.lifts, self._lifting.is_in_doubt)

    def _left_keyframe(self) -> bool:
        way = self._odom_from_keyframe.between(self._odom_from_body)
        far = np.hypot(way.x_m, way.y_m) > KEYFRAME_DISTANCE_IN_REACHES * self._patch.reach_m
        return bool(far) or abs(way.theta_rad) > KEYFRAME_TURN_RAD
