"""Watches one camera's pictures for what a person has to put right: too dark, out of focus, a dirty lens, one that has moved.

Most looks are taken at every tenth frame, those for dirt every five centimetres: together about 0.3 ms a frame.
"""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from agent.drivers.camera import UNDECODABLE, WRONG_SIZE
from agent.geometry import calibrated_projection
from agent.rig import Body, Calibration
from agent.slam.drawing_check import wrong_drawing
from agent.slam.rig_sensitivity import circle_px
from agent.vision.brightness import Brightness
from agent.vision.lens_dirt import CELL_PX, LEAST_CELLS, RINGS, LensDirt
from agent.vision.lens_seat import LensSeat
from agent.vision.liveness import DARK, FROZEN
from agent.vision.sharpness import Focus
from protocol.geometry import Array
from protocol.messages import RigValue, Sighting

EVERY = 10  # frames
WAY_M, TURN_RAD = 0.05, 0.1  # driven between two looks at dirt
WIDTH_PX = 640  # wider pictures are reduced first
SMALL = 4  # pixels of that to one of the small picture in which dirt is looked for
BODY_SHARE, NEAR_SHARE = 0.8, 1.25  # of the rim's radius: within it all is the own body, beyond it all is floor ...
FAR_RAD = 1.05  # ... to this angle off the axis, 1.75 camera heights away
MIDDLE_SHARE = 1.6  # of the rim's radius: the part of the picture in which sharpness is measured
SIGHTING_MARGIN_RAD = 0.15
FAULTS = 3  # frames in a row with the same fault are told

NO_CHANGE = np.zeros(8)
REMEDIES = {
    DARK: "camera: black pictures: take the cap off the lens, or give light",
    FROZEN: "camera: the same picture though the wheels turn: pull its plug and put it in again",
    UNDECODABLE: "camera: pictures that are cut short: a shorter or better cable, or a lower rate_hz",
    WRONG_SIZE: "camera: pictures of another size than the calibration's: set the camera's size, or calibrate for this one",
}


class CameraWatch:
    """Takes frames as they come; `complaint` tells the worst that is wrong with them."""

    def __init__(self, calibration: Calibration, body: Body) -> None:
        self._calibration, self._body = calibration, body
        self._scale = max(1, round(calibration.width_px / WIDTH_PX))
        rim_px = circle_px(calibration, NO_CHANGE, body.body_radius_m, body.body_height_m)
        self._middle_px = rim_px.mean(axis=0)
        self._rim_px = float(np.hypot(*(rim_px - self._middle_px).T).mean())
        self._brightness, self._focus = Brightness(), Focus()
        self._seat = _seat(calibration, body, rim_px)
        self._dirt = _dirt(calibration, self._middle_px, self._rim_px, self._scale)
        self._angles_rad: Array | None = None  # of the wheels, at the last look at dirt
        self._frames = self._faults = 0
        self._fault = ""

    def fail(self, fault: str) -> None:
        """Take a frame that has no usable picture."""
        self._faults = self._faults + 1 if fault == self._fault else 1
        self._fault = fault

    def look(self, picture: NDArray[np.uint8], angles_rad: Array, sightings: Sequence[Sighting] = ()) -> None:
        """Take a picture, (rows, cols, 3) BGR, with the wheels at (2,) [rad], and the robots that were seen in it."""
        self._fault, self._faults = "", 0
        self._frames += 1
        if self._frames % EVERY == 0:
            self._brightness.look(picture)
            self._focus.look(self._middle(picture))
        if self._seat is not None and self._frames % EVERY == 1:
            self._seat.look(_grey(picture))
        if self._dirt is not None and self._has_moved(angles_rad):
            self._dirt.look(self._small(picture), self._hiding(sightings))

    def complaint(self, rig: Sequence[RigValue] = ()) -> str:
        """Return what a person has to put right, in one line with the remedy; empty where all is well. `rig` is the rig as it was found."""
        if self._faults >= FAULTS and self._fault in REMEDIES:
            return REMEDIES[self._fault]
        too_dark = self._brightness.complaint
        return too_dark or self._seat_complaint(rig) or self._focus.complaint or self._dirt_complaint()

    def _seat_complaint(self, rig: Sequence[RigValue]) -> str:
        return (self._seat.complaint if self._seat is not None else "") or wrong_drawing(rig, self._calibration)

    def _dirt_complaint(self) -> str:
        if self._dirt is None or not self._dirt.dirty.any():
            return ""
        rows, cols = np.nonzero(self._dirt.dirty)
        u, v = (round((float(np.median(at)) + 0.5) * CELL_PX * SMALL * self._scale) for at in (cols, rows))
        return f"camera: the lens is dirty where pixel ({u}, {v}) is: wipe it with a soft cloth"

    def _has_moved(self, angles_rad: Array) -> bool:
        """Tell whether the robot has driven on since the last look at dirt."""
        if self._angles_rad is not None:
            left_m, right_m = self._body.wheel_radius_m * (angles_rad - self._angles_rad)
            if abs(left_m + right_m) < 2.0 * WAY_M and abs(right_m - left_m) < TURN_RAD * self._body.wheel_base_m:
                return False
        self._angles_rad = angles_rad
        return True

    def _middle(self, picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Return the own body and the floor around it, in grey, reduced."""
        half = round(MIDDLE_SHARE * self._rim_px)
        u, v = np.rint(self._middle_px).astype(int)
        part = picture[max(v - half, 0) : v + half, max(u - half, 0) : u + half]
        return _grey(_reduced(part, self._scale))

    def _small(self, picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Return the picture, its whole cells only, in green, reduced."""
        half = self._scale * SMALL // 2
        small = _reduced(np.ascontiguousarray(picture[::half, ::half, 1]), 2)
        return small[: small.shape[0] // CELL_PX * CELL_PX, : small.shape[1] // CELL_PX * CELL_PX]

    def _hiding(self, sightings: Sequence[Sighting]) -> Array:
        """Return where robots hide the floor, (n, 2): bearing and half width [rad]."""
        radius_m = self._body.body_radius_m
        halves = [np.arcsin(min(radius_m / seen.range_m, 1.0)) + SIGHTING_MARGIN_RAD for seen in sightings]
        return np.array([(seen.bearing_rad, half) for seen, half in zip(sightings, halves, strict=True)]).reshape(-1, 2)


def _seat(calibration: Calibration, body: Body, rim_px: Array) -> LensSeat | None:
    """Return what watches the rim; None where its deck's lengths are not stated."""
    if body.deck_radius_m is None or body.deck_height_m is None:
        return None
    deck_px = circle_px(calibration, NO_CHANGE, body.deck_radius_m, body.deck_height_m)
    return LensSeat(deck_px, rim_px, calibration.focal_px[0])


def _dirt(calibration: Calibration, middle_px: Array, rim_px: float, scale: int) -> LensDirt | None:
    """Return what looks for dirt, in cells that show floor going by and the own body; None where there are too few of either."""
    step = CELL_PX * SMALL * scale
    cols, rows = np.meshgrid(np.arange(calibration.width_px // step), np.arange(calibration.height_px // step))
    pixels = (np.stack([cols, rows], axis=-1).reshape(-1, 2) + 0.5) * step - 0.5
    radius_px = np.hypot(*(pixels - middle_px).T)
    projection = calibrated_projection(calibration)
    place_m = projection.floor_from_pixels(pixels)
    away = projection.rays_from_pixels(pixels) @ projection.body_from_camera[:3, 2]
    floor = (radius_px > NEAR_SHARE * rim_px + 0.5 * step) & (away > np.cos(FAR_RAD)) & np.isfinite(place_m).all(axis=1)
    bearing_rad = np.nan_to_num(np.arctan2(place_m[:, 1], place_m[:, 0]))
    body = radius_px < BODY_SHARE * rim_px - 0.5 * step
    if floor.sum() < LEAST_CELLS * RINGS or not body.any():
        return None
    return LensDirt(*(field.reshape(rows.shape) for field in (radius_px, bearing_rad, floor, body)))


def _reduced(picture: NDArray[np.uint8], scale: int) -> NDArray[np.uint8]:
    if scale == 1:
        return picture
    size = (picture.shape[1] // scale, picture.shape[0] // scale)
    return np.asarray(cv2.resize(picture[: size[1] * scale, : size[0] * scale], size, interpolation=cv2.INTER_AREA), np.uint8)


def _grey(picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
    return np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY), np.uint8)
