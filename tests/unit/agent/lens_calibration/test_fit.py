"""Lenses of 60 to 220 degrees, found again from the corners that the simulated world's lens draws."""

from __future__ import annotations

import numpy as np
import pytest

from agent.lens_calibration.board import Board
from agent.lens_calibration.camera import FRAME, BoardPose, Camera
from agent.lens_calibration.fit import LensFit, as_kannala_brandt, fit_lens
from agent.lens_calibration.radial import KANNALA_BRANDT, UNIFIED, RadialFamily
from protocol.errors import ConfigError
from protocol.geometry import Array
from tests.unit.agent.lens_calibration.boards import BOARD, HEIGHT_PX, LENSES, WIDTH_PX, shoot

SIZE_PX = (WIDTH_PX, HEIGHT_PX)
NOISE_PX = 0.1
UNIFIED_VALUES = np.array([105.0, 104.0, 240.0, 181.0, 1.7, -0.05, 0.002])


def direction_errors_rad(fit: LensFit, degrees: int) -> Array:
    """Return the angles between what found and true lens say of the pixels where corners were seen; a common turn of both is no error."""
    pixels = np.concatenate(fit.corners)
    found, true = fit.camera.rays(pixels), LENSES[degrees].rays(pixels)
    left, _, right = np.linalg.svd(true.T @ found)
    return np.asarray(np.linalg.norm(found @ (left @ right).T - true, axis=1))


@pytest.mark.parametrize("degrees", sorted(LENSES))
def test_a_lens_is_found_again_to_a_fraction_of_a_pixel(degrees: int) -> None:
    fit = fit_lens(BOARD, shoot(degrees, 16).corners(NOISE_PX), SIZE_PX)
    assert len(fit.used) == 16
    assert fit.best.rms_px < 1.5 * NOISE_PX
    assert fit.camera.values[:2] == pytest.approx([LENSES[degrees].fx, LENSES[degrees].fy], rel=5e-3)
    assert np.percentile(direction_errors_rad(fit, degrees), 95) * LENSES[degrees].px_per_rad < 0.5


def test_corners_without_noise_give_the_very_lens() -> None:
    fit = fit_lens(BOARD, shoot(185, 10).corners(0.0), SIZE_PX)
    lens = LENSES[185]
    assert fit.camera.family is KANNALA_BRANDT
    assert fit.camera.values[:FRAME] == pytest.approx([lens.fx, lens.fy, lens.cx, lens.cy], abs=1e-3)
    assert fit.camera.values[FRAME:] == pytest.approx(lens.coefficients, abs=1e-4)


@pytest.mark.slow
def test_the_stated_uncertainty_is_that_of_many_calibrations() -> None:
    shooting = shoot(185, 10)
    fits = [fit_lens(BOARD, shooting.corners(NOISE_PX, seed), SIZE_PX) for seed in range(10)]
    values = np.array([fit.camera.values[:FRAME] for fit in fits])
    stated = np.sqrt(np.diag(fits[0].best.covariance))[:FRAME]
    assert np.all(values.std(axis=0) < 2.0 * stated)
    assert np.all(values.std(axis=0) > 0.4 * stated)


def test_pictures_with_wrong_corners_are_left_out() -> None:
    corners = shoot(185, 12).corners(NOISE_PX)
    random = np.random.default_rng(3)
    corners[2] = corners[2] + random.normal(0.0, 6.0, corners[2].shape)
    corners[7] = random.permutation(corners[7])
    fit = fit_lens(BOARD, corners, SIZE_PX)
    assert fit.used == (0, 1, 3, 4, 5, 6, 8, 9, 10, 11)
    assert fit.best.rms_px < 1.5 * NOISE_PX


def test_a_lens_of_the_other_family_is_found_and_written_as_kannala_brandt() -> None:
    true = Camera(UNIFIED, UNIFIED_VALUES)
    corners = [true.project(pose.apply(BOARD.points_m)) for pose in shoot(185, 12).poses]
    fit = fit_lens(BOARD, corners, SIZE_PX)
    assert fit.camera.family is UNIFIED
    assert fit.camera.values == pytest.approx(UNIFIED_VALUES, abs=1e-2)
    written, off_px = as_kannala_brandt(fit.camera, 1.4)
    angle = np.linspace(0.0, 1.4, 50)
    rays = np.column_stack([np.sin(angle), np.zeros(50), np.cos(angle)])
    assert np.abs(written.project(rays) - true.project(rays)).max() < off_px + 0.01
    assert off_px < 0.05


@pytest.mark.parametrize(
    ("family", "values"),
    [(KANNALA_BRANDT, np.array([104.0, 103.0, 240.0, 180.0, 0.02, -0.01, 0.003, -0.0004])), (UNIFIED, UNIFIED_VALUES)],
)
def test_derivatives_are_those_of_small_steps(family: RadialFamily, values: Array) -> None:
    [pose] = shoot(185, 1).poses
    drawn = Camera(family, values).draw(BOARD.points_m, pose)
    step = 1e-6
    for i, by_value in enumerate(np.moveaxis(drawn.by_lens, -1, 0)):
        moved = values.copy()
        moved[i] += step
        assert (Camera(family, moved).project(pose.apply(BOARD.points_m)) - drawn.pixels) / step == pytest.approx(by_value, abs=1e-2)
    for i, by_pose in enumerate(np.moveaxis(drawn.by_pose, -1, 0)):
        moved_pose: BoardPose = pose.moved(step * np.eye(6)[i])
        there = Camera(family, values).project(moved_pose.apply(BOARD.points_m))
        assert (there - drawn.pixels) / step == pytest.approx(by_pose, rel=1e-3, abs=5e-2)


@pytest.mark.parametrize("family", [KANNALA_BRANDT, UNIFIED])
def test_a_pixel_gives_back_the_ray_that_fell_on_it(family: RadialFamily) -> None:
    camera = Camera(family, np.array([104.0, 103.0, 240.0, 180.0, *family.start]))
    angle = np.linspace(0.01, 1.9, 40)
    rays = np.column_stack([np.sin(angle) * np.cos(3.0 * angle), np.sin(angle) * np.sin(3.0 * angle), np.cos(angle)])
    assert camera.rays(camera.project(rays)) == pytest.approx(rays, abs=1e-6)


@pytest.mark.parametrize(("board", "complaint"), [((2, 6, 0.03), "3x3 inner corners"), ((8, 6, 0.0), "metres"), ((8, 6, 32.5), "metres")])
def test_what_is_no_board_is_refused(board: tuple[int, int, float], complaint: str) -> None:
    with pytest.raises(ConfigError, match=complaint):
        Board(*board)
