"""A route of cells becomes a curve that a robot can drive: taut, away from things, and without sharp bends.

First an elastic band (Quinlan and Khatib, "Elastic bands: connecting path planning and control", ICRA 1993) pulls the route tight and
pushes it off what is near; then a smoothing spline (Whittaker's, with second differences) takes out what is left of the corners.
"""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.linalg import solveh_banded

from mapserver.formation.costmap import CostMap
from mapserver.formation.planning import Berth
from mapserver.formation.trail import STEP_M, resampled
from protocol.geometry import Array

COARSE_M, COARSE_ROUNDS = 0.10, 40
FINE_M, FINE_ROUNDS = 0.025, 40
PULL, PUSH = 0.5, 0.1  # of the way to the neighbours' middle; of the clearance that is lacking
GRADIENT_REACH_M = 0.02
MOST_PUSH_M = 0.01  # in one round
STIFFNESS_M = 0.12  # the length over which the spline rounds a corner
JOINT_STIFFNESS_M, JOINT_M = 0.25, 0.25  # so much longer just behind the trail so far, whose direction is given, and over how long
FIXED_WEIGHT = 1e4
TIGHTER, TIGHTENINGS = 6.0, 4  # where the spline cuts a corner too closely, the band counts for more, so often at most
LEAD_IN_M = 0.15  # of the trail so far, which the spline continues


def smooth(route_m: Array, before_m: Array, cost_map: CostMap, berth: Berth) -> Array:
    """Return samples, shape (n, 2), one every `STEP_M` (nearly) from the start of a route, excluded, to its end.

    `before_m`, shape (m, 2), is the trail that leads to the route's start, which is its last sample; m may be 1.
    """
    band_m = _relaxed(resampled(route_m, COARSE_M), cost_map, berth, COARSE_ROUNDS)
    band_m = _relaxed(resampled(band_m, FINE_M), cost_map, berth, FINE_ROUNDS)
    stride = round(FINE_M / STEP_M)
    lead_m = before_m[: -round(LEAD_IN_M / STEP_M) - 1 : -1][stride::stride][::-1]
    return _rounded(lead_m, band_m, cost_map, berth)


def _relaxed(band_m: Array, cost_map: CostMap, berth: Berth, rounds: int) -> Array:
    """Return the band after so many rounds of pull and push; both ends stay."""
    band_m = band_m.copy()
    for _ in range(rounds if len(band_m) > 2 else 0):
        inner_m = band_m[1:-1]
        pull = PULL * (0.5 * (band_m[:-2] + band_m[2:]) - inner_m)
        lacking_m = np.maximum(berth.wished_m - cost_map.clearance_m(inner_m), 0.0)
        push = np.minimum(PUSH * lacking_m, MOST_PUSH_M)[:, None] * cost_map.uphill(inner_m, GRADIENT_REACH_M)
        band_m[1:-1] = inner_m + pull + push
    return band_m


def _rounded(lead_m: Array, band_m: Array, cost_map: CostMap, berth: Berth) -> Array:
    """Return the spline through the fixed lead-in and near the band, sampled after the lead-in."""
    points_m = np.vstack([lead_m, band_m])
    after_m = FINE_M * (np.arange(len(points_m)) - len(lead_m))
    joint = np.exp(-after_m / JOINT_M) if len(lead_m) else np.zeros(len(points_m))
    weights = (FINE_M / (STIFFNESS_M + JOINT_STIFFNESS_M * joint)) ** 4
    weights[: len(lead_m) + 1] = weights[-1] = FIXED_WEIGHT
    curve_m = _whittaker(points_m, weights)
    for _ in range(TIGHTENINGS):
        tight = cost_map.clearance_m(curve_m) < np.minimum(cost_map.clearance_m(points_m), berth.least_m + STEP_M)
        if not tight.any():
            break
        weights[tight] *= TIGHTER
        curve_m = _whittaker(points_m, weights)
    return _sampled(curve_m, len(lead_m))


def _whittaker(points_m: Array, weights: Array) -> Array:
    """Return the points p that minimise sum w |p - points|^2 + sum |second difference of p|^2, shape (n, 2)."""
    count = len(points_m)
    if count < 5:
        return points_m
    bands = np.zeros((3, count))
    bands[0, 2:] = 1.0
    bands[1, 1:] = -4.0
    bands[1, [1, -1]] = -2.0
    bands[2] = 6.0
    bands[2, [1, -2]] = 5.0
    bands[2, [0, -1]] = 1.0
    bands[2] += weights
    return np.asarray(solveh_banded(bands, weights[:, None] * points_m))


def _sampled(curve_m: Array, lead: int) -> Array:
    """Return a cubic spline through points, sampled every `STEP_M` after the point with number `lead`."""
    lengths_m = np.maximum(np.hypot(*np.diff(curve_m, axis=0).T), 1e-6)
    arcs_m = np.concatenate([[0.0], np.cumsum(lengths_m)])
    count = max(round((arcs_m[-1] - arcs_m[lead]) / STEP_M), 1)
    wanted_m = np.linspace(arcs_m[lead], arcs_m[-1], count + 1)[1:]
    return np.asarray(CubicSpline(arcs_m, curve_m)(wanted_m))
