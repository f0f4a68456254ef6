"""The classical method does follow the floor: it is no straw man. And the enlarged pictures have a calibration that fits them."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from agent.geometry import calibrated_projection
from agent.rig import Body, Calibration
from protocol.geometry import Pose2
from tests.bench.classical import ClassicalMethod
from tests.bench.correction import WholePictureCorrection
from tests.bench.frames import enlarged_calibration

BODY = Body(body_radius_m=0.075, body_height_m=0.30, wheel_base_m=0.12, wheel_radius_m=0.03)
LOOKS_DOWN = np.array([[0.0, -1.0, 0.0, 0.0], [-1.0, 0.0, 0.0, 0.0], [0.0, 0.0, -1.0, 0.5], [0.0, 0.0, 0.0, 1.0]])
SMALL = Calibration(640, 480, (147.0, 147.0), (319.5, 239.5), (0.0, 0.0, 0.0, 0.0), math.radians(185.0), LOOKS_DOWN)
LARGE = enlarged_calibration(SMALL, 2)


def floor_picture(arena_from_body: Pose2) -> NDArray[np.uint8]:
    """Return what a robot sees that stands on a floor of random tiles, with its own dark body in the middle."""
    columns, rows = np.meshgrid(np.arange(LARGE.width_px), np.arange(LARGE.height_px))
    pixels = np.stack([columns, rows], axis=-1).reshape(-1, 2)
    floor = calibrated_projection(LARGE).floor_from_pixels(pixels)
    seen = np.isfinite(floor).all(axis=1) & (np.hypot(*np.nan_to_num(floor, nan=9.0).T) < 2.0)
    places = arena_from_body.apply(np.where(seen[:, None], floor, 0.0))
    texture = cv2.GaussianBlur(np.random.default_rng(5).uniform(0, 255, (1000, 1000)).astype(np.float32), (0, 0), 1.5)
    u, v = ((places.T + 2.5) / 0.005).astype(np.float32)
    grey = cv2.remap(texture, u.reshape(rows.shape), v.reshape(rows.shape), cv2.INTER_LINEAR)
    body = np.hypot(*(pixels - LARGE.centre_px).T).reshape(rows.shape) < 100.0
    spotted_body = np.where((columns + rows) % 16 < 8, 20.0, 90.0)
    return np.repeat(np.where(body, spotted_body, grey).astype(np.uint8)[..., None], 3, axis=2)


def test_it_finds_a_known_motion_to_a_millimetre() -> None:
    motion = Pose2(0.03, -0.01, 0.05)
    method = ClassicalMethod(BODY, LARGE)
    assert method.step(floor_picture(Pose2.identity())) is None
    found = method.step(floor_picture(motion))
    assert found is not None
    assert [found.x_m, found.y_m] == pytest.approx([motion.x_m, motion.y_m], abs=0.001)
    assert found.theta_rad == pytest.approx(motion.theta_rad, abs=0.003)


def test_without_anything_to_follow_it_finds_no_motion() -> None:
    method = ClassicalMethod(BODY, SMALL)
    flat = np.full((480, 640, 3), 90, np.uint8)
    assert method.step(flat) is None
    assert method.step(flat) is None


def test_an_enlarged_picture_shows_the_same_floor_at_the_same_place() -> None:
    """The corner of a picture is at (-0.5, -0.5), whatever its size."""
    small, large = calibrated_projection(SMALL), calibrated_projection(LARGE)
    corners = np.array([[319.5, 100.0], [200.0, 239.5], [-0.5 + 256.0, -0.5 + 128.0]])
    assert small.floor_from_pixels(corners) == pytest.approx(large.floor_from_pixels(2.0 * (corners + 0.5) - 0.5))


def test_correction_of_the_whole_picture_makes_straight_lines_straight() -> None:
    correction = WholePictureCorrection(calibrated_projection(LARGE).lens, (LARGE.width_px, LARGE.height_px))
    line = np.stack([np.full(60, 0.2), np.linspace(-0.4, 0.4, 60)], axis=-1)
    picture = np.zeros((LARGE.height_px, LARGE.width_px, 3), np.uint8)
    bent = calibrated_projection(LARGE).pixels_from_floor(line)
    cv2.polylines(picture, [np.rint(bent * 16).astype(np.int32)[:, None]], False, (255, 255, 255), 3, cv2.LINE_AA, 4)
    rows, columns = np.nonzero(correction.correct(picture)[..., 0] > 128)
    middle = np.array([rows[columns == column].mean() for column in np.unique(columns)])
    assert len(middle) > 300
    assert np.ptp(middle[5:-5]) < 1.0  # without the line's round ends
    assert np.ptp(bent[:, 1]) > 10.0
