"""Lanes beside a trail, and references that are true to them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from mapserver.formation.trail import STEP_M, Lane, resampled, sample
from protocol.geometry import Array, Pose2

RADIUS_M = 0.6


def circle() -> Lane:
    """Return a trail that turns left with a radius of 0.6 m."""
    angles = np.arange(0.0, 2.0, STEP_M / RADIUS_M)
    return Lane.through(RADIUS_M * np.stack([np.sin(angles), 1.0 - np.cos(angles)], axis=1))


def constant(lane: Lane, left_m: float) -> Array:
    return np.full(len(lane.points_m), left_m)


def test_on_the_inside_of_a_bend_a_lane_is_shorter() -> None:
    trail = circle()
    inner = trail.beside(constant(trail, 0.2)).at(0.6, 0.15)
    assert inner.speed_m_s == pytest.approx(0.15 * (RADIUS_M - 0.2) / RADIUS_M, rel=1e-3)
    assert inner.turn_rad_s == pytest.approx(0.15 / RADIUS_M, rel=1e-3)


@pytest.mark.parametrize("left_m", [0.0, 0.25, -0.3])
def test_a_unicycle_that_drives_as_told_stays_on_its_lane(left_m: float) -> None:
    trail = circle()
    lane = trail.beside(constant(trail, left_m) * np.linspace(0.0, 1.0, len(trail.points_m)) ** 2)
    elapsed_s, rate_m_s, arc_m = 0.01, 0.15, 0.2
    pose = lane.at(arc_m, rate_m_s).arena_from_body
    while arc_m < 1.0:
        middle = lane.at(arc_m + 0.5 * rate_m_s * elapsed_s, rate_m_s)
        pose = pose @ Pose2.exp((middle.speed_m_s * elapsed_s, 0.0, middle.turn_rad_s * elapsed_s))
        arc_m += rate_m_s * elapsed_s
    wanted = lane.at(arc_m, rate_m_s).arena_from_body
    assert math.dist(pose[:2], wanted[:2]) < 2e-3
    assert pose.theta_rad == pytest.approx(wanted.theta_rad, abs=5e-3)


def test_samples_are_held_at_both_ends() -> None:
    rows = np.array([[0.0, 1.0], [2.0, 3.0], [4.0, 5.0]])
    assert sample(rows, np.array([-1.0, 0.005, 9.0])).tolist() == [[0.0, 1.0], [1.0, 2.0], [4.0, 5.0]]


def test_resampling_keeps_both_ends_and_the_spacing() -> None:
    points_m = resampled(np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 0.5]]), 0.1)
    assert points_m[0].tolist() == [0.0, 0.0]
    assert points_m[-1].tolist() == [1.0, 0.5]
    assert np.hypot(*np.diff(points_m, axis=0).T) == pytest.approx(np.full(15, 0.1))
