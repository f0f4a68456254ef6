"""What speaks for a robot where its silhouette was fitted, and against a thing whose pattern has edges in the same places.

A robot is no floor from its foot to its rim, has less of what is no floor beside it than a larger thing has, and is a tube, about as bright
all across it at one height. None of it is certain in one picture: it adds up over pictures, as the logarithm of a likelihood ratio.
"""

from __future__ import annotations

import math

import numpy as np

from agent.rig import Body
from agent.vision.floor_projection import FloorProjection
from agent.vision.floor_view import FloorView, Picture
from agent.vision.outlines import Mask
from agent.vision.robot_fit import RobotFit
from protocol.geometry import Array

LEAST_SHOWN = 0.7  # of a robot's near side that is no floor: with less it is floor, whatever its pattern
NEAR_FACE, ASIDE = 0.85, np.array([-0.5, -0.25, 0.0, 0.25, 0.5])  # of a body's radius: where its side shows ...
BESIDE_M, BESIDE_RAD = 0.03, np.array([-1.6, 1.6])  # ... from it, and about its axis from the camera's direction: what is left and right
UPWARDS = np.linspace(0.05, 0.95, 10)  # of its height
USUAL_CHANGE = 0.15  # of the logarithm of brightness across a robot, where not all of it is in the picture
MOST_CHANGE = 0.25  # that is counted: the edge of a shadow may lie across a robot
_LOG = np.log(np.arange(256) + 4.0)  # the offset keeps noise in the dark small

# By logistic regression over what is fitted in simulated and recorded drives: `python -m tests.bench.robot_looks`. To miss a robot, which
# ties the swarm together, costs more than to take a thing for one, so that the last is 2.5 more.
_WEIGHTS = np.array([28.7, -9.6, -2.4, -41.8, -11.7])  # in the order of `looks`


def robot_evidence(fit: RobotFit, grey: Picture, not_floor: Mask, body: Body, view: FloorView, projection: FloorProjection) -> float:
    """Return the logarithm of how much likelier a fit is where a robot stands than elsewhere; -inf where floor shows through it.

    `grey` is the camera picture, and `not_floor` the mask of its view, (rows, cols) each.
    """
    seen = looks(fit, grey, not_floor, body, view, projection)
    return -math.inf if seen[0] < LEAST_SHOWN else float(seen @ _WEIGHTS)


def looks(fit: RobotFit, grey: Picture, not_floor: Mask, body: Body, view: FloorView, projection: FloorProjection) -> Array:
    """Return what tells robots from other things, (5,).

    How much of it, and beside it, is no floor, the misfit, how much brightness changes across it (standard deviation of its logarithm),
    and 1.
    """
    face_px = projection.pixels_from_points(_around(fit.centre_m, body, projection, NEAR_FACE * body.body_radius_m, ASIDE))
    left_and_right = _around(fit.centre_m, body, projection, body.body_radius_m + BESIDE_M, BESIDE_RAD)
    shown, beside = (_share(not_floor, view.view_pixels(pixels)) for pixels in (face_px, projection.pixels_from_points(left_and_right)))
    return np.array([shown, beside, fit.misfit_px, _change_across(grey, face_px), 1.0])


def _around(centre_m: Array, body: Body, projection: FloorProjection, radius_m: float, turns_rad: Array) -> Array:
    """Return points, (n, 3) [m; body], at all heights of a robot, about its axis at some turns from the camera's direction."""
    away = projection.body_from_camera[:2, 3] - centre_m
    angles = np.arctan2(away[1], away[0]) + turns_rad
    feet = centre_m + radius_m * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    return np.column_stack([np.tile(feet, (len(UPWARDS), 1)), np.repeat(body.body_height_m * UPWARDS, len(feet))])


def _share(not_floor: Mask, places: Array) -> float:
    """Return at how many of some places, (n, 2) [view px], those in view, the mask shows something: 0 to 1, 0 where none is in view."""
    values = _picked(not_floor, places)
    return float(values.mean()) if len(values) else 0.0


def _change_across(grey: Picture, face_px: Array) -> float:
    """Return how much the logarithm of brightness changes across a face, in the mean of all heights, given its pixels, row by row."""
    values = _LOG[_picked(grey, face_px)]
    if len(values) < len(face_px):
        return USUAL_CHANGE
    return min(float(values.reshape(-1, len(ASIDE)).std(axis=1).mean()), MOST_CHANGE)


def _picked(picture: Picture, places: Array) -> Picture:
    """Return the values of a picture at those of some places, (n, 2) [px], that lie in it."""
    u, v = np.rint(np.nan_to_num(places, nan=-1.0)).astype(np.intp).T
    rows, cols = picture.shape
    inside = (u >= 0) & (u < cols) & (v >= 0) & (v < rows)
    return np.asarray(picture[v[inside], u[inside]])
