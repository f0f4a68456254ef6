"""The rig as it is found to be while driving: own rim, floor and upright edges are weighed against what drawing and calibration say.

An information filter. Drawings are believed until what is seen contradicts them: then the robot goes on with the rig as it is found to be.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from agent.rig import Calibration
from agent.slam.ego_motion import Pair
from agent.slam.rig_floor import FloorPair, Information
from agent.slam.rig_parameters import CAMERA, HEIGHT, PARAMETERS, WHEELS, prior_sigma
from agent.slam.rig_sensitivity import FloorSensitivity
from agent.slam.rig_uprights import Shaking, UprightSensitivity, upright_information
from agent.vision.own_rim import RimShift
from agent.vision.upright_edges import UprightEdges
from protocol.geometry import Array

RIM_RADIUS_SIGMA_PX, RIM_CENTRE_SIGMA_PX = 0.3, 0.16  # a rim is no perfect circle, and how light becomes grey levels moves its border
FRESH_WAY_M, FRESH_TURN_RAD = 0.08, 0.15  # between two pictures that both tell of the rig
AGAIN = 0.1  # of those: a drawing that was found wrong once is no longer believed
TAKEN_AS_DRAWN_M = 1e-6  # sigma of a height that nothing tells
NEWS = 0.5  # what a pair counts: pairs with one keyframe share its noise and part of their way
CONTRADICTING = ((CAMERA, 26.1), (WHEELS, 18.5))  # chi-squared of 8 and of 4 degrees of freedom that one in a thousand reaches by chance


class RigEstimate(NamedTuple):
    """How far the rig is from its drawing, and how well that is known."""

    change: Array  # (PARAMETERS,)
    covariance: Array  # (PARAMETERS, PARAMETERS)


class RigEstimator:
    """Gathers what is seen of the rig; `in_use` is the change that the pictures given to it are seen with."""

    def __init__(self, drawn: Calibration, *, has_scale: bool) -> None:
        """Without a scale in the picture, the camera's height is what all other lengths are measured by."""
        self._sigma = prior_sigma(drawn)
        if not has_scale:
            self._sigma[HEIGHT] = TAKEN_AS_DRAWN_M
        self._prior = np.diag(self._sigma**-2)
        self._driven = self._rim = Information(np.zeros((PARAMETERS, PARAMETERS)), np.zeros(PARAMETERS))  # floor and upright edges; own rim
        self._shaking = Shaking()
        self._last: Pair | None = None
        self.in_use: Array = np.zeros(PARAMETERS)

    def see_rim(self, shift: RimShift, sensitivity: Array) -> None:
        """Take where the own rim is in the picture, beside where the drawing has it, with its (3, 8) sensitivity there."""
        terms = np.zeros((3, PARAMETERS))
        terms[:, CAMERA] = sensitivity
        sigma_px = np.array([RIM_RADIUS_SIGMA_PX, RIM_CENTRE_SIGMA_PX, RIM_CENTRE_SIGMA_PX])
        weighted = terms / sigma_px[:, None] ** 2
        self._rim = Information(weighted.T @ terms, weighted.T @ np.array([shift.radius_px, *shift.centre_px]))

    def see_floor(self, pair: Pair, sensitivity: FloorSensitivity) -> None:
        """Take a pair of pictures, as seen with the rig in use, unless it tells nothing new."""
        if not self._is_fresh(pair):
            return
        self._last = pair
        told = FloorPair(pair.keyframe.fine, pair.glance).information(pair.keyframe_from_body, pair.path, sensitivity, self._sigma)
        self._add(told, NEWS)

    def see_uprights(self, edges: UprightEdges, sensitivity: UprightSensitivity) -> None:
        """Take upright edges, as seen with the rig in use."""
        found = self.estimate()
        off = (found.change - self.in_use)[CAMERA]
        told = upright_information(edges, sensitivity, off, found.covariance[CAMERA, CAMERA], self._shaking.sigma_rad)
        if told is not None:
            self._add(told.information)
            self._shaking.add(told.shaking_rad2)

    def estimate(self) -> RigEstimate:
        """Return the rig as far as it is known by now."""
        covariance = np.asarray(np.linalg.inv(self._prior + self._driven.matrix + self._rim.matrix), np.float64)
        return RigEstimate(covariance @ (self._driven.vector + self._rim.vector), covariance)

    def adopt(self) -> bool:
        """Go over to the rig as it is found to be where the one in use is contradicted; tell whether that changes anything."""
        found = self.estimate()
        adopted = self.in_use.copy()
        for part, limit in CONTRADICTING:
            off = found.change[part] - self.in_use[part]
            if off @ np.linalg.solve(found.covariance[part, part], off) > (AGAIN * limit if self.in_use[part].any() else limit):
                adopted[part] = found.change[part]
        is_changed = bool((adopted != self.in_use).any())
        self.in_use = adopted
        return is_changed

    def _is_fresh(self, pair: Pair) -> bool:
        since = (
            pair.keyframe_from_body
            if self._last is None or self._last.keyframe is not pair.keyframe
            else (self._last.keyframe_from_body.between(pair.keyframe_from_body))
        )
        return bool(np.hypot(since.x_m, since.y_m) > FRESH_WAY_M) or abs(since.theta_rad) > FRESH_TURN_RAD

    def _add(self, told: Information, news: float = 1.0) -> None:
        """Add what was told about the rig in use, and counts so much."""
        matrix, vector = self._driven
        self._driven = Information(matrix + news * told.matrix, vector + news * (told.vector + told.matrix @ self.in_use))
