"""How fast the leader may go along its trail, so that nobody is asked for more than a robot can do."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.ndimage import maximum_filter1d, minimum_filter1d

from mapserver.formation.trail import STEP_M, Lane, sample
from protocol.geometry import Array

MOST_TURN_RAD_S = 1.2
ACCELERATION_M_S2 = 0.12
NARROW_M, NARROW_SHARE = 0.10, 0.6  # with less room around its body than that, the leader goes at this share of its cruise
LEAST_RATE_M_S = 0.01


def speeds_along(lanes: Sequence[Lane], backs_m: Array, room_m: Array, cruise_m_s: float, most_m_s: float) -> Array:
    """Return the most at which the leader's arc length may grow, for every sample of it, shape (n,) [m/s]; 0 at the end.

    `backs_m`, shape (k, n), are the followers', `room_m`, shape (n,), is what there is around the leader's body. Nobody drives faster than
    `most_m_s`, nor backwards, nor turns faster than MOST_TURN_RAD_S.
    """
    count = len(room_m)
    limits = np.where(room_m < NARROW_M, NARROW_SHARE * cruise_m_s, cruise_m_s)
    for lane, back_m in zip(lanes, np.vstack([np.zeros((1, count)), backs_m]), strict=True):
        arc_m = STEP_M * np.arange(count) - back_m
        pace = np.abs(1.0 - np.gradient(back_m, STEP_M))  # metres of the trail that it goes for one of the leader's
        limits = np.minimum(limits, most_m_s / np.maximum(pace * sample(lane.stretch, arc_m), 1e-6))
        sharpest = maximum_filter1d(np.abs(lane.turns), 3)  # a lane's own samples lie between those of the leader
        limits = np.minimum(limits, MOST_TURN_RAD_S / np.maximum(pace * sample(sharpest, arc_m), 1e-6))
    limits = minimum_filter1d(limits, 3)  # what is interpolated between two samples keeps the limits of both
    limits[-1] = 0.0
    return stoppable(limits)


def stoppable(limits: Array) -> Array:
    """Return speeds, shape (n,), from which every limit further on is met by braking: v^2 <= v_there^2 + 2 a (distance)."""
    twice_m2_s2 = 2.0 * ACCELERATION_M_S2 * STEP_M * np.arange(len(limits))
    ahead = np.minimum.accumulate((limits**2 + twice_m2_s2)[::-1])[::-1]
    return np.asarray(np.sqrt(np.maximum(ahead - twice_m2_s2, 0.0)))
