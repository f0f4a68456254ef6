"""The reduced picture and the places on the floor that it shows."""

from __future__ import annotations

import numpy as np
import pytest

from agent.vision.floor_projection import FloorProjection
from agent.vision.floor_view import make_floor_view
from agent.vision.lens import KannalaBrandt
from protocol.errors import GeometryError
from protocol.geometry import Pose2
from tests.synthetic import BODY_HEIGHT_M, BODY_RADIUS_M, CENTRE_PX, FLOOR, FOCAL_PX, NOTHING, OWN_BODY, render
from tests.unit.agent.eyes import BODY_FROM_CAMERA, PROJECTION, SIZE_PX, VIEW


def twice_as_fine() -> FloorProjection:
    """Return the camera with four times as many pixels: pixel centre p of the coarse picture is 2 p + 0.5 of the fine one."""
    lens = KannalaBrandt(2 * FOCAL_PX, 2 * FOCAL_PX, 2 * CENTRE_PX[0] + 0.5, 2 * CENTRE_PX[1] + 0.5)
    return FloorProjection(lens, BODY_FROM_CAMERA)


def test_only_floor_is_valid_and_neither_the_own_body_nor_the_black_outside() -> None:
    labels = render("paint", Pose2.identity()).labels[VIEW.crop]
    assert (labels == OWN_BODY).any()
    assert (labels == NOTHING).any()
    assert (labels[VIEW.valid] == FLOOR).all()


def test_every_pixel_shows_the_floor_at_its_range_and_bearing() -> None:
    rows, cols = np.nonzero(VIEW.valid)
    range_m, bearing = VIEW.range_m[rows, cols], VIEW.bearing_rad[rows, cols]
    there = np.stack([range_m * np.cos(bearing), range_m * np.sin(bearing)], axis=-1)
    pixels = VIEW.camera_pixels(np.stack([cols, rows], axis=-1))
    assert PROJECTION.pixels_from_floor(there) == pytest.approx(pixels, abs=1e-3)


def test_range_and_bearing_by_hand_ahead_and_to_the_left() -> None:
    nadir = np.round(VIEW.nadir_px).astype(int)
    ahead, left = (nadir[1] - 147, nadir[0]), (nadir[1], nadir[0] - 147)  # one radian off the axis
    assert VIEW.range_m[ahead] == pytest.approx(0.5 * np.tan(1.0), rel=0.02)
    assert VIEW.bearing_rad[ahead] == pytest.approx(0.0, abs=0.01)
    assert VIEW.bearing_rad[left] == pytest.approx(np.pi / 2, abs=0.01)


def test_a_finer_camera_gives_the_same_view() -> None:
    fine = make_floor_view(twice_as_fine(), (2 * SIZE_PX[0], 2 * SIZE_PX[1]), BODY_RADIUS_M, BODY_HEIGHT_M)
    assert fine.scale == 2
    assert fine.crop == VIEW.crop
    assert np.array_equal(fine.valid, VIEW.valid)
    assert fine.range_m[fine.valid] == pytest.approx(VIEW.range_m[VIEW.valid], rel=1e-5)
    assert fine.nadir_px == pytest.approx(VIEW.nadir_px)


def test_reducing_averages_the_pixels_that_it_unites() -> None:
    fine = make_floor_view(twice_as_fine(), (2 * SIZE_PX[0], 2 * SIZE_PX[1]), BODY_RADIUS_M, BODY_HEIGHT_M)
    coarse = np.random.default_rng(1).integers(0, 246, (SIZE_PX[1], SIZE_PX[0], 3), dtype=np.uint8)
    picture = np.repeat(np.repeat(coarse, 2, axis=0), 2, axis=1)
    picture[::2, ::2] += 8  # one pixel in four: two levels in the mean
    assert np.array_equal(fine.reduce(picture), coarse[fine.crop] + 2)


def test_the_reach_is_kept() -> None:
    assert VIEW.reach_m == pytest.approx(2.3)
    assert VIEW.range_m[VIEW.valid].max() < VIEW.reach_m
    assert VIEW.range_m[VIEW.valid].min() > VIEW.body_range_m > BODY_RADIUS_M * 0.5 / 0.2


def test_a_camera_below_the_rim_is_refused() -> None:
    with pytest.raises(GeometryError, match="body_height_m"):
        make_floor_view(PROJECTION, SIZE_PX, BODY_RADIUS_M, 0.5)


def test_a_picture_without_floor_is_refused() -> None:
    with pytest.raises(GeometryError, match="no floor"):
        make_floor_view(PROJECTION, SIZE_PX, 10.0, BODY_HEIGHT_M)
