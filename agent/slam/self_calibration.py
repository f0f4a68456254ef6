"""The rig calibrates itself while driving: the own rim at first, then floor and upright edges at every few centimetres."""

from __future__ import annotations

import numpy as np

from agent.rig import Body, Calibration
from agent.slam.ego_motion import Pair
from agent.slam.odometry import WheelGeometry, travel
from agent.slam.rig_estimator import RigEstimator
from agent.slam.rig_parameters import LAG, TILT, changed_calibration, changed_wheels
from agent.slam.rig_report import rig_values
from agent.slam.rig_sensitivity import FloorSensitivity, circle_px, rim_sensitivity
from agent.slam.rig_uprights import UprightSensitivity
from agent.vision.floor_view import Picture
from agent.vision.own_rim import OwnRim
from agent.vision.upright_edges import UprightView
from agent.wheel_history import WheelState
from protocol.messages import RigValue

RIM_PICTURES = (1, 8)  # after so many the rim is measured
LOOK_ROUND_EVERY = 2  # pictures, for upright edges, and only after ...
LOOK_ROUND_WAY_M, LOOK_ROUND_TURN_RAD = 0.02, 0.05  # ... driving on: to one that stands, the next picture tells nothing new
KNOWN_TILT_RAD = 0.0006  # one sigma: then upright edges have told enough
NO_CHANGE = np.zeros(8)
SETTLING_FRAMES = 5  # between two changes of the rig in use


class SelfCalibration:
    """Knows the rig as drawn, and as it is in use."""

    def __init__(self, drawn: Calibration, body: Body) -> None:
        """Without the lengths of the deck the camera's height is taken as drawn, and all other lengths are found beside it."""
        self._drawn, self._body = drawn, body
        self._has_scale = body.deck_radius_m is not None and body.deck_height_m is not None
        self._estimator = RigEstimator(drawn, has_scale=self._has_scale)
        self._drawn_wheels = WheelGeometry(body.wheel_radius_m, body.wheel_base_m)
        self._rim: OwnRim | None = None
        self._pictures = self._since_change = 0
        self._since_round, self._looked_at_rad = LOOK_ROUND_EVERY, np.full(2, np.inf)  # of the wheels: nowhere yet
        if body.deck_radius_m is not None and body.deck_height_m is not None:
            self._deck = (body.deck_radius_m, body.deck_height_m)
            circles = self._deck, (body.body_radius_m, body.body_height_m)
            self._rim = OwnRim(*(circle_px(drawn, NO_CHANGE, *circle) for circle in circles))

    @property
    def calibration(self) -> Calibration:
        """The camera's calibration in use."""
        return changed_calibration(self._drawn, self._estimator.in_use)

    @property
    def wheels(self) -> WheelGeometry:
        """The wheels in use."""
        return changed_wheels(self._drawn_wheels, self._estimator.in_use)

    @property
    def wheel_lag_s(self) -> float:
        """How much later than they were read wheel readings are stamped, as in use."""
        return float(self._estimator.in_use[LAG])

    def values(self) -> tuple[RigValue, ...]:
        """Return the rig as far as it is known by now."""
        return rig_values(self._drawn, self._drawn_wheels, self._estimator.estimate(), has_scale=self._has_scale)

    def look(self, grey: Picture) -> None:
        """Take one more camera picture of the own rim."""
        if self._rim is None or self._pictures >= RIM_PICTURES[-1]:
            return
        self._rim.add(grey)
        self._pictures += 1
        shift = self._rim.shift() if self._pictures in RIM_PICTURES else None
        if shift is not None:
            self._estimator.see_rim(shift, rim_sensitivity(self._drawn, *self._deck))

    def look_round(self, grey: Picture, wheels: WheelState, view: UprightView, sensitivity: UprightSensitivity) -> None:
        """Take the upright edges in a camera picture, if they tell anything new."""
        self._since_round += 1
        way_m, turn_rad = travel(wheels.angles_rad - self._looked_at_rad, self.wheels)
        has_moved = not (abs(way_m) < LOOK_ROUND_WAY_M and abs(turn_rad) < LOOK_ROUND_TURN_RAD)
        if self._since_round < LOOK_ROUND_EVERY or not has_moved or self._tilt_sigma_rad() < KNOWN_TILT_RAD:
            return
        self._since_round, self._looked_at_rad = 0, wheels.angles_rad
        self._estimator.see_uprights(view.edges(grey, travel(wheels.speeds_rad_s, self.wheels)[1]), sensitivity)

    def compare(self, pair: Pair | None, sensitivity: FloorSensitivity) -> None:
        """Take two pictures of the same floor."""
        if pair is not None:
            self._estimator.see_floor(pair, sensitivity)

    def adopt(self) -> bool:
        """Go over to the rig as it is found to be, where what is seen contradicts the one in use; tell whether that is so."""
        self._since_change += 1
        is_due = self._pictures == RIM_PICTURES[0] or self._since_change > SETTLING_FRAMES
        if not is_due or not self._estimator.adopt():
            return False
        self._since_change = 0
        return True

    def _tilt_sigma_rad(self) -> float:
        return float(np.sqrt(np.diag(self._estimator.estimate().covariance)[TILT].max()))


class AsDrawn(SelfCalibration):
    """Learns of the rig, and goes on with the drawing all the same."""

    def adopt(self) -> bool:
        """Stay with the drawing."""
        return False
