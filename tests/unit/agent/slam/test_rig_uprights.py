"""Upright edges tell the camera's tilt, and a lens centre that is off from that."""

from __future__ import annotations

import numpy as np
import pytest

from agent.geometry import calibrated_projection
from agent.slam.rig_floor import SHAKING_RAD
from agent.slam.rig_parameters import CAMERA, CENTRE, TILT, prior_sigma
from agent.slam.rig_uprights import Shaking, UprightSensitivity, upright_information
from agent.vision.upright_edges import UprightEdges, UprightView
from protocol.geometry import Array
from tests.unit.agent.eyes import CALIBRATION

ANGLES_RAD = UprightView(calibrated_projection(CALIBRATION), CALIBRATION.height_px, CALIBRATION.readout_s).angles_rad
SENSITIVITY = UprightSensitivity(CALIBRATION, ANGLES_RAD)
COVARIANCE = np.diag(prior_sigma(CALIBRATION)[CAMERA] ** 2)
STILL_RAD = 1e-6


def edges(missing: Array, strays: int = 0) -> UprightEdges:
    """Return edges near and far all round, as seen by a camera that is off by (8,), among so many that are not upright."""
    count, bands = 48, len(ANGLES_RAD)
    bearings = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    near = np.arange(count) % 2 == 0
    first = np.where(near, 0, bands // 2)
    last = np.where(near, bands // 2, bands - 1)
    upright = UprightEdges(bearings, np.zeros(count), np.full(count, 1e-4), first, last)
    slants = -SENSITIVITY.at(upright) @ missing
    slants[:strays] += np.linspace(0.02, 0.1, strays)
    return upright._replace(slant_rad=slants)


def off_by(tilt_rad: tuple[float, float], centre_px: tuple[float, float] = (0.0, 0.0)) -> Array:
    missing = np.zeros(CAMERA.stop)
    missing[TILT], missing[CENTRE] = tilt_rad, centre_px
    return missing


@pytest.mark.parametrize("strays", [0, 12])
def test_near_and_far_edges_tell_tilt_and_lens_centre_apart(strays: int) -> None:
    missing = off_by((0.006, -0.004), (-1.5, 2.0))
    told = upright_information(edges(missing, strays), SENSITIVITY, np.zeros(CAMERA.stop), COVARIANCE, STILL_RAD)
    assert told is not None
    seen = [*range(TILT.start, TILT.stop), *range(CENTRE.start, CENTRE.stop)]
    found = np.linalg.solve(told.information.matrix[np.ix_(seen, seen)], told.information.vector[seen])
    assert found[:2] == pytest.approx(missing[TILT], abs=2e-4)
    assert found[2:] == pytest.approx(missing[CENTRE], abs=0.15)


def test_a_body_that_may_shake_tells_less_of_its_tilt() -> None:
    sigmas = []
    for shaking_rad in (STILL_RAD, SHAKING_RAD):
        told = upright_information(edges(off_by((0.0, 0.0))), SENSITIVITY, np.zeros(CAMERA.stop), COVARIANCE, shaking_rad)
        assert told is not None
        sigmas.append(told.information.matrix[TILT, TILT][0, 0] ** -0.5)
    assert sigmas[1] == pytest.approx(np.hypot(sigmas[0], SHAKING_RAD), rel=0.05)


def test_two_edges_tell_nothing() -> None:
    many = edges(off_by((0.0, 0.0)))
    few = UprightEdges(many.bearing_rad[:2], many.slant_rad[:2], many.sigma_rad[:2], many.first[:2], many.last[:2])
    assert upright_information(few, SENSITIVITY, np.zeros(CAMERA.stop), COVARIANCE, SHAKING_RAD) is None


def test_a_body_that_rolls_smoothly_is_believed_more_from_picture_to_picture() -> None:
    shaking = Shaking()
    assert shaking.sigma_rad == pytest.approx(SHAKING_RAD)
    for _ in range(100):
        told = upright_information(edges(off_by((0.0, 0.0))), SENSITIVITY, np.zeros(CAMERA.stop), COVARIANCE, shaking.sigma_rad)
        assert told is not None
        shaking.add(told.shaking_rad2)
    assert shaking.sigma_rad < 0.4 * SHAKING_RAD
