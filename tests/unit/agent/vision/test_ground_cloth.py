"""Real circular fisheye photos of a chequered cloth: what is straight on the ground comes out straight of our lens."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from agent.vision.lens import KannalaBrandt
from protocol.geometry import Array

SQUARE, ORIGIN = 40.0, 300.0  # of the cloth's chequers on the ground plane of the photos' own files, both ways
ROWS = range(1, 6)
COLUMNS = {"front": (*range(1, 5), *range(11, 15)), "back": (*range(1, 5), *range(11, 15))} | {
    side: (*range(1, 7), *range(18, 25)) for side in ("left", "right")
}
RUN_AWAY_PX, RUN_AWAY = 5.0, 12.0  # where a fold hides the corner
MOST_CROOKED = 0.004  # of a line's length: the cloth has folds


class Cloth:
    """One photo with its published lens and ground plane."""

    def __init__(self, folder: Path, side: str) -> None:
        storage = cv2.FileStorage(str(folder / f"{side}.yaml"), cv2.FILE_STORAGE_READ)
        matrix, distortion, homography, scale, shift = (
            np.asarray(storage.getNode(key).mat(), np.float64)
            for key in ("camera_matrix", "dist_coeffs", "project_matrix", "scale_xy", "shift_xy")
        )
        self.grey = np.asarray(cv2.imread(str(folder / f"{side}.png"), cv2.IMREAD_GRAYSCALE), np.uint8)
        self.lens = KannalaBrandt(matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2], *distortion.ravel())
        flat = matrix.copy()
        flat[[0, 1], [0, 1]] *= scale.ravel()
        flat[:2, 2] += shift.ravel()
        self._ground_from_ray = homography @ flat

    def ground(self, rays: Array) -> Array:
        """Return where rays (n, 3) meet the ground plane, (n, 2)."""
        places = rays / rays[:, 2:] @ self._ground_from_ray.T
        return np.asarray(places[:, :2] / places[:, 2:])

    def corners(self, row: int, columns: tuple[int, ...]) -> Array:
        """Return the corners of the cloth's chequers along a row as they are in the photo, (n, 2) [px]."""
        expected = np.array([[ORIGIN + SQUARE * column, ORIGIN + SQUARE * row, 1.0] for column in columns])
        rays = expected @ np.linalg.inv(self._ground_from_ray).T
        start = self.lens.project(rays * np.sign(rays[:, 2:]))
        start, expected = start[np.isfinite(start[:, 0])], expected[np.isfinite(start[:, 0]), :2]
        criteria = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 40, 1e-3)
        found = cv2.cornerSubPix(self.grey, start.astype(np.float32).reshape(-1, 1, 2), (4, 4), (-1, -1), criteria)
        pixels = found.reshape(-1, 2).astype(np.float64)
        is_near = np.linalg.norm(pixels - start, axis=1) < RUN_AWAY_PX
        is_near &= np.linalg.norm(self.ground(self.lens.unproject(pixels)) - expected, axis=1) < RUN_AWAY
        return np.asarray(pixels[is_near])


def crookedness(points: Array) -> float:
    """Return by how much points (n, 2) stray from a line (rms), as a share of its length."""
    centred = points - points.mean(axis=0)
    along = np.linalg.svd(centred, full_matrices=False)[2]
    return float((centred @ along[1]).std() / np.ptp(centred @ along[0]))


@pytest.mark.parametrize("side", sorted(COLUMNS))
def test_lines_of_the_cloth_come_out_straight(shared: Path, side: str) -> None:
    folder = shared / "real" / "ground_cloth"
    if not folder.is_dir():
        pytest.skip("the photos of the ground cloth are not here")
    cloth = Cloth(folder, side)
    lines = [cloth.corners(row, COLUMNS[side]) for row in ROWS]
    assert min(map(len, lines)) >= 8
    straightened = [crookedness(cloth.ground(cloth.lens.unproject(line))) for line in lines]
    assert max(straightened) < MOST_CROOKED
    assert sum(straightened) < 0.25 * sum(map(crookedness, lines))
