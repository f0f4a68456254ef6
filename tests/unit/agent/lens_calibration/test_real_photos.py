"""Photos of real chessboards by real fisheye lenses: every board is found, and the lens is that of others who calibrated it."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from agent.lens_calibration.board import Board
from agent.lens_calibration.calibration import LensCalibration, Photo, calibrate_lens

PUBLISHED_JY_LEFT = [558.478, 560.507, 620.459, 381.939]  # OpenCV's own test of cv2.fisheye


def calibrated(folder: Path, board: Board) -> LensCalibration:
    """Return the calibration from a folder's photos; the test is skipped where it is absent."""
    if not folder.is_dir():
        pytest.skip(f"the photos of real boards are not here: no folder {folder.name}")
    photos = [Photo(file.name, np.asarray(cv2.imread(str(file), cv2.IMREAD_GRAYSCALE), np.uint8)) for file in sorted(folder.glob("*.jpg"))]
    return calibrate_lens(photos, board, lambda name: None)


@pytest.mark.slow
def test_a_lens_that_opencv_calibrates_is_found_as_published(shared: Path) -> None:
    calibration = calibrated(shared / "real" / "calibration" / "jy_left", Board(8, 6, 0.04))
    assert len(calibration.photos) == 34
    assert all(photo.counts for photo in calibration.photos)
    assert calibration.verdict.rms_px < 0.30
    assert calibration.fit.camera.values[:4] == pytest.approx(PUBLISHED_JY_LEFT, rel=0.01)
    assert calibration.verdict.grade == "good"


@pytest.mark.slow
def test_a_circular_fisheye_at_which_opencv_raises_is_calibrated(shared: Path) -> None:
    calibration = calibrated(shared / "real" / "calibration" / "fish_2", Board(6, 8, 0.117))
    assert len(calibration.photos) == 16
    assert all(photo.corners is not None for photo in calibration.photos)
    assert {photo.name: photo.complaint for photo in calibration.photos if photo.complaint} == {
        "Fisheye2_16.jpg": "shows the same as Fisheye2_1.jpg"
    }
    assert calibration.verdict.rms_px < 0.25
    assert calibration.field.is_circle
    assert calibration.verdict.grade == "good"
