"""Photos of a chessboard as the simulated world's lens draws them: it shares no line with the lens under test but the numbers."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from agent.lens_calibration.board import Board
from agent.lens_calibration.camera import BoardPose
from agent.lens_calibration.corners import Picture
from protocol.geometry import Array
from sim.world.lens import KannalaBrandtLens

BOARD = Board(7, 5, 0.03)
WIDTH_PX, HEIGHT_PX = 480, 360
NOISE, BLUR_PX = 3.0, 0.7
_FINE = 2  # rays per pixel and direction
_WALL, _PAPER, _INK, _OUTSIDE = 120.0, 220.0, 30.0, 4.0
_MARGIN = 0.8  # of white paper round the squares, in squares

LENSES = {
    60: KannalaBrandtLens(560.0, 562.0, 243.0, 176.0, np.radians(62.0), (-0.04, 0.01, 0.0, 0.0)),
    120: KannalaBrandtLens(240.0, 241.0, 236.0, 183.0, np.radians(120.0), (0.03, -0.02, 0.004, 0.0)),
    185: KannalaBrandtLens(104.0, 104.3, 241.5, 178.2, np.radians(185.0), (0.02, -0.01, 0.003, -0.0004)),
    220: KannalaBrandtLens(90.0, 90.2, 238.1, 181.4, np.radians(220.0), (-0.02, 0.003, -0.0008, 0.00005)),
}


@dataclass(frozen=True)
class Shooting:
    """Photos of the board by one lens."""

    lens: KannalaBrandtLens
    poses: list[BoardPose]

    def corners(self, noise_px: float, seed: int = 0) -> list[Array]:
        """Return where the board's inner corners are drawn, (n, 2) [px] a photo, with noise."""
        random = np.random.default_rng(seed)
        exact = [self.lens.pixels(pose.apply(BOARD.points_m)) for pose in self.poses]
        return [each + random.normal(0.0, noise_px, each.shape) for each in exact]

    def photos(self, seed: int = 0) -> list[Picture]:
        """Return the photos, blurred and with noise."""
        random = np.random.default_rng(seed)
        rays = self._rays()
        return [self._photo(rays, pose, random) for pose in self.poses]

    def _rays(self) -> Array:
        places = (np.arange(_FINE * max(WIDTH_PX, HEIGHT_PX)) + 0.5) / _FINE - 0.5
        across, down = np.meshgrid(places[: _FINE * WIDTH_PX], places[: _FINE * HEIGHT_PX])
        return self.lens.rays(np.stack([across, down], axis=-1))

    def _photo(self, rays: Array, pose: BoardPose, random: np.random.Generator) -> Picture:
        here = rays @ pose.rotation  # in the board's frame
        eye = -pose.rotation.T @ pose.translation_m
        ahead = -eye[2] / here[..., 2]
        column, row = ((eye[i] + ahead * here[..., i]) / BOARD.square_m for i in (0, 1))
        is_square = (column >= -1.0) & (row >= -1.0) & (column <= BOARD.columns) & (row <= BOARD.rows) & (ahead > 0.0)
        wide = 1.0 + _MARGIN
        is_paper = (column >= -wide) & (row >= -wide) & (column <= BOARD.columns + _MARGIN) & (row <= BOARD.rows + _MARGIN) & (ahead > 0.0)
        with np.errstate(invalid="ignore"):
            is_dark = (np.floor(column) + np.floor(row)) % 2.0 == 0.0
        grey = np.where(is_square & is_dark, _INK, np.where(is_paper, _PAPER, _WALL))
        grey = np.where(np.isnan(rays[..., 0]), _OUTSIDE, grey)
        small = cv2.resize(grey, (WIDTH_PX, HEIGHT_PX), interpolation=cv2.INTER_AREA)
        noisy = cv2.GaussianBlur(small, (0, 0), BLUR_PX) + random.normal(0.0, NOISE, small.shape)
        return np.asarray(np.clip(noisy, 0, 255), np.uint8)


def shoot(degrees: int, count: int, seed: int = 1, reach: float = 0.85) -> Shooting:
    """Return photos by the lens of so many degrees: the board turned and tilted, out to a share of the field."""
    lens = LENSES[degrees]
    random = np.random.default_rng(seed)
    poses: list[BoardPose] = []
    while len(poses) < count:
        pose = _pose(random, lens, reach)
        pixels, points = lens.pixels(pose.apply(BOARD.points_m)), pose.apply(BOARD.points_m)
        seen = np.arctan2(np.hypot(points[:, 0], points[:, 1]), points[:, 2]) < reach * lens.widest_rad
        if seen.all() and ((pixels > 8.0) & (pixels < [WIDTH_PX - 9.0, HEIGHT_PX - 9.0])).all():
            poses.append(pose)
    return Shooting(lens, poses)


def _pose(random: np.random.Generator, lens: KannalaBrandtLens, reach: float) -> BoardPose:
    """Return a board that looks at the lens from some direction in the field, but for a tilt."""
    angle, turn = reach * lens.widest_rad * np.sqrt(random.uniform()), random.uniform(0.0, 2.0 * np.pi)
    towards = _turned((-np.sin(turn) * angle, np.cos(turn) * angle, 0.0))
    tilt = random.uniform(0.35, 0.75) * np.array([np.cos(spin := random.uniform(0.0, 2.0 * np.pi)), np.sin(spin), 0.0])
    rotation = towards @ _turned(tuple(tilt)) @ _turned((0.0, 0.0, random.uniform(0.0, 2.0 * np.pi)))
    wide_rad = min(0.75, 0.8 * lens.widest_rad) * random.uniform(0.8, 1.2)
    distance_m = 0.5 * BOARD.square_m * BOARD.columns / np.tan(0.5 * wide_rad)
    middle = rotation @ BOARD.points_m.mean(axis=0)
    return BoardPose(rotation, towards @ np.array([0.0, 0.0, distance_m]) - middle)


def _turned(vector: tuple[float, ...]) -> Array:
    return np.asarray(cv2.Rodrigues(np.array(vector))[0])
