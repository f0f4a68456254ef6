"""Corners followed over many frames, and what their parallax tells: floor, standing thing, or robot on the move.

A point at height h whose true place is p projects from a camera at c and height H onto the floor at q = s p + (1 - s) c with s = H / (H -
h). So while the robot drives, q is a straight line over c, of slope b = 1 - s: zero for what lies on the floor, negative for what stands
on it, and positive for what moves along with the robot, since robots in formation stay where they are in the picture. This is the paper's
distinction of robots and obstacles by their motion vectors (IV.2) carried over from two frames to the whole time a point is in view.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from protocol.geometry import Array, Pose2

REMEMBERING = 0.97  # per frame; what a point did two seconds ago counts half
PIXEL_SIGMA = 0.35  # of a tracked corner [px of the picture it is tracked in]
SURE_SIGMAS = 4.0
MOVING_SLOPE = 0.25  # nothing static is above zero; between lies what noise and slow things do
MISFIT = 9.0  # chi-square per observation beyond which a point moves by itself
FEW_OBSERVATIONS = 4


@dataclass(frozen=True, eq=False)
class Tracks:
    """n corners in view. Running weighted sums of where the camera was and where the corner appeared on the floor, both [m; odom]."""

    pixels: Array  # (n, 2) in the newest picture
    labels: NDArray[np.int32]  # (n,) region that each lies on; 0: none
    observations: NDArray[np.int32]  # (n,)
    weight: Array  # (n,) sum of weights [1/m^2]
    eye_m: Array  # (n, 2) mean camera position
    place_m: Array  # (n, 2) mean appearance on the floor
    eye_power: Array  # (n,) weighted sum of squares of the camera's way
    cross_power: Array  # (n,) ... of the camera's way times the appearance's
    place_power: Array  # (n,) ... of the appearance's way

    def __len__(self) -> int:
        """Count the corners."""
        return len(self.labels)

    def select(self, rows: NDArray[np.generic]) -> Tracks:
        """Return the corners of a mask or of indices."""
        return Tracks(*(values[rows] for values in vars(self).values()))

    def slopes(self) -> tuple[Array, Array]:
        """Return the slope b of every corner and its standard deviation, (n,) each; infinite deviation where the camera has not moved."""
        power = np.maximum(self.eye_power, 1e-12)
        sigma = np.where((self.eye_power > 1e-9) & (self.observations >= 2), 1.0 / np.sqrt(power), np.inf)
        return np.where(np.isfinite(sigma), self.cross_power / power, 0.0), sigma

    def misfit(self) -> Array:
        """Return how badly a straight line fits, (n,): chi-square per observation."""
        slope, sigma = self.slopes()
        unexplained = self.place_power - np.where(np.isfinite(sigma), slope * self.cross_power, 0.0)
        return np.asarray(unexplained / np.maximum(2.0 * self.observations - 3.0, 1.0))

    def moving(self) -> NDArray[np.bool_]:
        """Tell which corners, (n,), surely move by themselves: along with the robot, or along no straight line."""
        slope, sigma = self.slopes()
        seen = self.observations >= FEW_OBSERVATIONS
        return seen & ((slope - SURE_SIGMAS * sigma > MOVING_SLOPE) | (self.misfit() > MISFIT))

    def settled(self, sigma: float) -> NDArray[np.bool_]:
        """Tell which corners, (n,), are static with a slope known to `sigma`."""
        return (self.slopes()[1] < sigma) & (self.observations >= FEW_OBSERVATIONS) & ~self.moving()

    def predicted_places(self, eye_m: Array) -> Array:
        """Return where the corners will appear on the floor, (n, 2) [m; odom], from a camera at `eye_m` (2,) [m; odom].

        A slope that is not yet known is taken for the floor's.
        """
        slope, sigma = self.slopes()
        trusted = np.where((sigma < 0.2) & (self.observations >= 3), slope, 0.0)
        return np.asarray(self.place_m + trusted[:, None] * (eye_m - self.eye_m))


def no_tracks() -> Tracks:
    """Return an empty set."""
    n, xy = np.zeros(0), np.zeros((0, 2))
    integers = np.zeros(0, np.int32)
    return Tracks(xy, integers, integers, n, xy, xy, n, n, n)


def begin(pixels: Array, labels: NDArray[np.int32], places_m: Array, sigmas_m: Array, eye_m: Array) -> Tracks:
    """Return new corners at `pixels` (n, 2) that appear at `places_m` (n, 2) [m; odom], to `sigmas_m` (n,), from `eye_m` (2,)."""
    count = len(pixels)
    zero = np.zeros(count)
    eyes = np.tile(eye_m, (count, 1))
    return Tracks(pixels, labels, np.ones(count, np.int32), sigmas_m**-2, eyes, places_m, zero, zero, zero)


def observe(tracks: Tracks, pixels: Array, places_m: Array, sigmas_m: Array, eye_m: Array) -> Tracks:
    """Return the corners with one observation more: Welford's running moments with weights and forgetting."""
    weight = REMEMBERING * tracks.weight + sigmas_m**-2
    share = (sigmas_m**-2 / weight)[:, None]
    eye_way, place_way = eye_m - tracks.eye_m, places_m - tracks.place_m
    eye, place = tracks.eye_m + share * eye_way, tracks.place_m + share * place_way
    gain = sigmas_m**-2
    return Tracks(
        pixels,
        tracks.labels,
        tracks.observations + np.int32(1),
        weight,
        eye,
        place,
        REMEMBERING * tracks.eye_power + gain * (eye_way * (eye_m - eye)).sum(axis=1),
        REMEMBERING * tracks.cross_power + gain * (eye_way * (places_m - place)).sum(axis=1),
        REMEMBERING * tracks.place_power + gain * (place_way * (places_m - place)).sum(axis=1),
    )


def join(first: Tracks, second: Tracks) -> Tracks:
    """Return all corners of both."""
    return Tracks(*(np.concatenate([a, b]) for a, b in zip(vars(first).values(), vars(second).values(), strict=True)))


def relabel(tracks: Tracks, labels: NDArray[np.int32]) -> Tracks:
    """Return the corners with other labels, (n,)."""
    return Tracks(**{**vars(tracks), "labels": labels})


def heights(slopes: Array, camera_height_m: float) -> Array:
    """Return the height, (n,) [m], of points with these slopes: from b = 1 - H / (H - h)."""
    return np.asarray(camera_height_m * (1.0 - 1.0 / np.maximum(1.0 - slopes, 1e-6)))


def place_sigmas(places_m: Array, odom_from_body: Pose2, camera_height_m: float, rad_per_px: float) -> Array:
    """Return how far off, (n,) [m], a corner's appearance (n, 2) [m; odom] may be: a pixel covers more floor the farther out it looks."""
    reach = np.hypot(places_m[:, 0] - odom_from_body.x_m, places_m[:, 1] - odom_from_body.y_m) / camera_height_m
    return np.asarray(PIXEL_SIGMA * rad_per_px * camera_height_m * (1.0 + reach**2))
