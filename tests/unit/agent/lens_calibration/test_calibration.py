"""From rendered photos to a lens and its verdict: bad photos are told, and data that cannot carry a calibration are refused."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from agent.lens_calibration.calibration import Photo, calibrate_lens
from agent.lens_calibration.camera import Camera
from agent.lens_calibration.corners import find_corners, find_corners_redrawn
from agent.lens_calibration.field import Field, field_of
from agent.lens_calibration.fit import fit_lens
from agent.lens_calibration.radial import KANNALA_BRANDT
from agent.lens_calibration.verdict import judge
from protocol.errors import ConfigError
from protocol.geometry import Array
from sim.world.lens import KannalaBrandtLens
from tests.unit.agent.lens_calibration.boards import BOARD, HEIGHT_PX, LENSES, WIDTH_PX, shoot

SIZE_PX = (WIDTH_PX, HEIGHT_PX)


def camera_of(lens: KannalaBrandtLens) -> Camera:
    return Camera(KANNALA_BRANDT, np.array([lens.fx, lens.fy, lens.cx, lens.cy, *lens.coefficients]))


def misses_px(found: Array, exact: Array) -> Array:
    """Return by how much corners are missed, (n,) [px]; they may be counted from either end."""
    return min((np.linalg.norm(order - exact, axis=1) for order in (found, found[::-1])), key=np.sum)


@pytest.mark.parametrize("degrees", sorted(LENSES))
def test_corners_are_found_to_a_quarter_of_a_pixel_and_better(degrees: int) -> None:
    shooting = shoot(degrees, 2, seed=5)
    for photo, exact in zip(shooting.photos(), shooting.corners(0.0), strict=True):
        found = find_corners(photo, BOARD)
        assert found is not None
        assert np.sqrt(np.mean(misses_px(found, exact) ** 2)) < 0.25


def test_a_board_is_found_in_the_picture_drawn_anew_too() -> None:
    shooting = shoot(220, 1, seed=5)
    [photo], [exact] = shooting.photos(), shooting.corners(0.0)
    found = find_corners_redrawn(photo, BOARD, camera_of(LENSES[220]))
    assert found is not None
    assert np.sqrt(np.mean(misses_px(found, exact) ** 2)) < 0.25


@pytest.mark.slow
def test_bad_photos_are_told_and_do_no_harm() -> None:
    shooting = shoot(185, 14, seed=2)
    photos = [Photo(f"{i}.png", grey) for i, grey in enumerate(shooting.photos())]
    smeared = cv2.blur(photos[3].grey, (1, 41))
    photos[3] = Photo("smeared.png", np.asarray(smeared, np.uint8))
    photos.append(replace(photos[5], name="copy.png"))
    photos.append(Photo("black.png", np.zeros_like(photos[0].grey)))
    searched: list[str] = []
    calibration = calibrate_lens(photos, BOARD, searched.append)
    complaints = {photo.name: photo.complaint for photo in calibration.photos if photo.complaint}
    assert searched == [photo.name for photo in photos]
    assert complaints["copy.png"] == "shows the same as 5.png"
    assert complaints["black.png"] == "the whole board was not found"
    assert "smeared.png" in complaints
    assert calibration.verdict.rms_px < 0.2
    assert calibration.fit.camera.values[:2] == pytest.approx([LENSES[185].fx, LENSES[185].fy], rel=5e-3)


def test_too_few_photos_with_a_board_are_refused() -> None:
    photos = [Photo(f"{i}.png", grey) for i, grey in enumerate(shoot(120, 2).photos())]
    with pytest.raises(ConfigError, match=r"7x5 inner corners was found in 2 different photos of 2; at least 4 are needed"):
        calibrate_lens(photos, BOARD, lambda name: None)


def test_a_board_that_was_everywhere_gives_a_good_verdict() -> None:
    fit = fit_lens(BOARD, shoot(185, 32, reach=0.95).corners(0.1), SIZE_PX)
    verdict = judge(fit, Field(LENSES[185].fx * 1.62, np.radians(92.5), True))
    assert (verdict.grade, verdict.reasons, verdict.advice) == ("good", (), ())
    assert verdict.error_at_1m_m < 0.002


def test_a_board_in_the_middle_alone_is_refused() -> None:
    fit = fit_lens(BOARD, shoot(185, 12, reach=0.35).corners(0.1), SIZE_PX)
    verdict = judge(fit, Field(LENSES[185].fx * 1.62, np.radians(92.5), True))
    assert verdict.grade == "refused"
    assert any("inner" in reason and "of the picture only" in reason for reason in verdict.reasons)


def test_boards_that_all_lie_alike_are_refused() -> None:
    shooting = shoot(60, 1, seed=8)
    [pose] = shooting.poses
    flat = pose._replace(rotation=np.eye(3), translation_m=np.array([-0.09, -0.06, 0.5]))
    poses = [flat.moved(np.array([0.0, 0.0, 0.0, 0.01 * i, 0.004 * i, 0.0])) for i in range(6)]
    fit = fit_lens(BOARD, replace(shooting, poses=poses).corners(0.1), SIZE_PX)
    verdict = judge(fit, Field(300.0, np.radians(31.0), False))
    assert verdict.grade == "refused"


def test_a_side_where_the_board_never_was_is_named() -> None:
    corners = [each for each in shoot(185, 40, reach=0.95).corners(0.1) if each[:, 0].max() < WIDTH_PX * 0.62]
    verdict = judge(fit_lens(BOARD, corners, SIZE_PX), Field(LENSES[185].fx * 1.62, np.radians(92.5), True))
    assert verdict.grade == "usable"
    assert any("towards the right" in reason for reason in verdict.reasons)


def test_the_image_circle_tells_the_field() -> None:
    shooting = shoot(185, 1)
    field = field_of(camera_of(LENSES[185]), shooting.photos()[0])
    assert field.is_circle
    assert np.degrees(field.half_angle_rad) == pytest.approx(92.5, abs=1.0)


def test_without_an_image_circle_the_field_reaches_into_the_picture_s_corners() -> None:
    field = field_of(camera_of(LENSES[120]), np.full((HEIGHT_PX, WIDTH_PX), 90, np.uint8))
    assert not field.is_circle
    rays = LENSES[120].rays(np.array([[WIDTH_PX - 1.0, 0.0]]))
    assert field.half_angle_rad == pytest.approx(float(np.arccos(rays[0, 2])) if np.isfinite(rays).all() else 1.25, rel=0.1)
