"""How far a lens sees: the image circle in its pictures, and the angle that belongs to it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from agent.lens_calibration.camera import Camera
from agent.lens_calibration.corners import Picture
from agent.vision.robust import robust_sigma
from protocol.geometry import Array

DARK_SHARE = 0.12  # of the bright parts' grey level: what stays below it in all pictures lies outside the image circle
LEAST_DARK_DIRECTIONS = 0.25  # of all directions, for there to be an image circle
MOST_UNROUND = 0.03  # of its radius: a border that strays farther is that of a dim room
DIRECTIONS = 360


class Field(NamedTuple):
    """The part of the picture that shows something."""

    radius_px: float  # from the lens's centre, along the picture's rows
    half_angle_rad: float
    is_circle: bool  # the picture shows the border of the image circle


def field_of(camera: Camera, brightest: Picture) -> Field:
    """Return the field of a lens, given the brightest that each pixel of (rows, cols) was in any picture.

    Where no image circle shows, the field reaches to the farthest corner of the picture. It ends where the lens stops telling directions.
    """
    height, width = brightest.shape
    centre, focal = camera.values[2:4], camera.values[:2]
    borders = _dark_borders_px(brightest, centre, focal / focal[0])
    is_circle = _is_round(borders)
    if is_circle:
        radius_px = float(np.median(borders))
    else:
        frame = np.array([[0.0, 0.0], [width - 1.0, 0.0], [0.0, height - 1.0], [width - 1.0, height - 1.0]])
        radius_px = float(np.hypot(*((frame - centre) / focal * focal[0]).T).max())
    half_angle = float(camera.angle(np.array([radius_px / focal[0]]))[0])
    return Field(radius_px, half_angle, is_circle)


def _is_round(borders_px: Array) -> bool:
    """Tell whether borders, (k,) [px] from the centre, are those of one circle."""
    if borders_px.size < LEAST_DARK_DIRECTIONS * DIRECTIONS:
        return False
    radius_px = float(np.median(borders_px))
    return robust_sigma(borders_px - radius_px) < MOST_UNROUND * radius_px


def _dark_borders_px(brightest: Picture, centre: Array, aspect: Array) -> Array:
    """Return how far out the picture is bright, in those directions in which it ends dark, (k,) [px along the rows]."""
    height, width = brightest.shape
    limit = DARK_SHARE * float(np.percentile(brightest, 95))
    steps = np.arange(float(np.hypot(width, height)))
    turns = np.linspace(0.0, 2.0 * np.pi, DIRECTIONS, endpoint=False)
    along = np.stack([np.cos(turns), np.sin(turns)], axis=-1) * aspect
    places = np.rint(centre + steps[None, :, None] * along[:, None, :]).astype(int)  # (directions, steps, 2)
    inside = np.asarray(((places >= 0) & (places < [width, height])).all(axis=-1), bool)
    clipped = np.clip(places, 0, [width - 1, height - 1])
    bright = np.asarray(inside & (brightest[clipped[..., 1], clipped[..., 0]] > limit), bool)
    last_bright = steps.size - 1 - np.argmax(bright[:, ::-1], axis=1)
    last_inside = steps.size - 1 - np.argmax(inside[:, ::-1], axis=1)
    ends_dark = bright.any(axis=1) & (last_bright < last_inside - 2)
    return np.asarray(last_bright[ends_dark] + 0.5)
