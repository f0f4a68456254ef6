"""Upright edges of boxes and robots are found, and slant by just as much as the vertical is off."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from agent.geometry import calibrated_projection
from agent.slam.rig_parameters import PARAMETERS, TILT, changed_calibration
from agent.vision.upright_edges import UprightEdges, UprightView
from protocol.geometry import Array, Pose2
from tests.synthetic import Box, Cylinder, render, robot
from tests.unit.agent.eyes import CALIBRATION

COLOURS = ((30.0, 60.0, 160.0), (160.0, 90.0, 30.0), (40.0, 140.0, 60.0))
THINGS = (
    Box(0.7, 0.2, 0.2, 0.15, 0.4, 0.2, COLOURS[0]),
    Box(-0.5, 0.5, 0.15, 0.2, 1.1, 0.15, COLOURS[1]),
    robot(0.1, -0.6),
    robot(-0.6, -0.3),
)


def seen(solids: tuple[Box | Cylinder, ...], tilt_rad: tuple[float, float] = (0.0, 0.0), turn_rad_s: float = 0.0) -> UprightEdges:
    """Return the edges found by a camera that is taken to be tilted so much more than it is."""
    change = np.zeros(PARAMETERS)
    change[TILT] = tilt_rad
    view = UprightView(calibrated_projection(changed_calibration(CALIBRATION, change)), CALIBRATION.height_px, readout_s=0.02)
    grey = cv2.cvtColor(render("paint", Pose2.identity(), solids).picture, cv2.COLOR_BGR2GRAY)
    return view.edges(np.asarray(grey, np.uint8), turn_rad_s)


def tilt_across(edges: UprightEdges) -> Array:
    """Return the tilt about x and y that explains the slants, (2,) [rad], by reweighted least squares."""
    terms = np.column_stack([np.cos(edges.bearing_rad), np.sin(edges.bearing_rad)])
    found: Array = np.zeros(2)
    weights: Array = 1.0 / edges.sigma_rad
    for _ in range(20):
        found = np.asarray(np.linalg.lstsq(terms * weights[:, None], edges.slant_rad * weights, rcond=None)[0], np.float64)
        misfits = (edges.slant_rad - terms @ found) / edges.sigma_rad
        weights = 1.0 / edges.sigma_rad / (1.0 + (misfits / (2.0 * np.median(np.abs(misfits)))) ** 2)
    return found


@pytest.mark.parametrize("tilt_rad", [(0.0, 0.0), (0.008, 0.0), (-0.005, 0.007)])
def test_edges_slant_by_the_tilt_that_is_not_known_of(tilt_rad: tuple[float, float]) -> None:
    edges = seen(THINGS, tilt_rad)
    assert len(edges.slant_rad) >= 8
    assert tilt_across(edges) == pytest.approx(np.array(tilt_rad), abs=0.002)


def test_an_edge_is_found_on_both_sides_of_a_robot() -> None:
    edges = seen((robot(0.6, 0.0),))
    side_rad = np.arcsin(0.075 / 0.6)
    for bearing_rad in (side_rad, -side_rad):
        assert np.abs(np.angle(np.exp(1j * (edges.bearing_rad - bearing_rad)))).min() < 0.005


def test_bare_floor_has_no_upright_edges() -> None:
    assert len(seen(()).slant_rad) <= 2


def test_a_body_that_turns_while_rows_are_taken_moves_edges_before_it_and_behind_it() -> None:
    still, turning = seen((robot(0.6, 0.0),)), seen((robot(0.6, 0.0),), turn_rad_s=2.0)
    assert len(still.bearing_rad) == len(turning.bearing_rad)
    moved_rad = turning.bearing_rad - still.bearing_rad
    assert moved_rad.min() > -0.02
    assert moved_rad.max() < -0.004
