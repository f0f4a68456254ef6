"""A small ray caster: what a robot's downward fisheye camera sees in a made-up room, and which pixels show what.

It shares no line with the code under test but the pose algebra: lens, floor and solids are its own. Same arguments, same picture.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from protocol.geometry import Pose2
from tests.synthetic_floors import CELL_M, SIDE_CELLS, floor_atlas

Field = NDArray[np.float32]
Colour = tuple[float, float, float]  # blue, green, red, 0 to 255

WIDTH_PX, HEIGHT_PX = 640, 480
FOCAL_PX, CENTRE_PX = 147.0, (320.2, 240.9)  # equidistant: radius = FOCAL_PX * angle
HALF_FIELD_RAD = np.radians(92.5)
CAMERA_HEIGHT_M = 0.5
BODY_RADIUS_M, BODY_HEIGHT_M = 0.075, 0.30
FLOOR, OWN_BODY, NOTHING = (
    0,
    -1,
    -2,
)  # labels; the n-th solid has label n, from one. NOTHING: above the horizon, or outside the image circle

_FINE = 2  # rays per pixel and direction
_WALL: Colour = (150.0, 155.0, 160.0)  # what is seen above the horizon
_DECK: Colour = (38.0, 36.0, 35.0)
_RIM: Colour = (222.0, 224.0, 226.0)
_RIM_WIDTH_M = 0.004
_LIGHT_RAD = 0.7  # walls that face this bearing are brightest


@dataclass(frozen=True)
class Box:
    """An upright box on the floor; `along_m` lies along theta."""

    x_m: float
    y_m: float
    theta_rad: float
    along_m: float
    across_m: float
    height_m: float
    colour: Colour

    @property
    def reach_m(self) -> float:
        """Radius of the circle round the footprint."""
        return 0.5 * float(np.hypot(self.along_m, self.across_m))

    def span(self, seen_from: Pose2, bearing: Field) -> tuple[Field, Field, Field]:
        """Return where rays along the floor enter and leave the footprint [m], and the normal's bearing [rad; arena]: (n,) each."""
        box = Pose2(self.x_m, self.y_m, self.theta_rad).between(seen_from)
        ray = bearing + np.float32(box.theta_rad)
        near, far = [], []
        for start, slope, half in ((box.x_m, np.cos(ray), self.along_m / 2), (box.y_m, np.sin(ray), self.across_m / 2)):
            safe = np.where(np.abs(slope) < 1e-6, 1e-6, slope)
            first, second = (-half - start) / safe, (half - start) / safe
            near.append(np.minimum(first, second))
            far.append(np.maximum(first, second))
        by_end = near[0] > near[1]
        normal = np.where(by_end, np.where(np.cos(ray) > 0, np.pi, 0.0), np.where(np.sin(ray) > 0, -np.pi / 2, np.pi / 2))
        return np.maximum(*near), np.minimum(*far), np.asarray(normal + self.theta_rad, np.float32)


@dataclass(frozen=True)
class Cylinder:
    """An upright cylinder on the floor; with a rim, a light ring runs round the edge of its top."""

    x_m: float
    y_m: float
    reach_m: float  # radius
    height_m: float
    colour: Colour
    rim: bool = False

    def span(self, seen_from: Pose2, bearing: Field) -> tuple[Field, Field, Field]:
        """Return where rays along the floor enter and leave the footprint [m], and the normal's bearing [rad; arena]: (n,) each."""
        centre = seen_from.inverse().apply((self.x_m, self.y_m))
        along = centre[0] * np.cos(bearing) + centre[1] * np.sin(bearing)
        beside = centre[1] * np.cos(bearing) - centre[0] * np.sin(bearing)
        half = np.sqrt(np.maximum(self.reach_m**2 - beside**2, 0.0))
        enter, leave = np.where(np.abs(beside) < self.reach_m, (along - half, along + half), np.inf)
        normal = np.pi + bearing + seen_from.theta_rad + np.arcsin(np.clip(beside / self.reach_m, -1.0, 1.0))
        return enter.astype(np.float32), leave.astype(np.float32), normal.astype(np.float32)


def robot(x_m: float, y_m: float) -> Cylinder:
    """Return another robot of the swarm: a dark deck with a light rim."""
    return Cylinder(x_m, y_m, BODY_RADIUS_M, BODY_HEIGHT_M, _DECK, rim=True)


class Shadow(NamedTuple):
    """A round shadow that takes `depth` of the light in its middle, and ends softly over `soft_m`."""

    x_m: float
    y_m: float
    radius_m: float
    depth: float = 0.35
    soft_m: float = 0.12


@dataclass(frozen=True, eq=False)
class Rendering:
    """A picture, (480, 640, 3) BGR, and what each pixel shows, (480, 640): FLOOR, OWN_BODY, NOTHING or the number of a solid."""

    picture: NDArray[np.uint8]
    labels: NDArray[np.int8]


def render(
    floor: str,
    pose: Pose2,
    solids: tuple[Box | Cylinder, ...] = (),
    shadows: tuple[Shadow, ...] = (),
    *,
    exposure: float = 1.0,
    tint: Colour = (1.0, 1.0, 1.0),
    vignetting: float = 0.35,
    noise: float = 2.0,
    seed: int = 0,
) -> Rendering:
    """Return what a robot at arena_from_body `pose` sees. `noise` is in grey levels, `seed` is the noise's; `tint` multiplies the floor."""
    angle, bearing, range_m = _rays()
    heading = bearing + np.float32(pose.theta_rad)
    x_m, y_m = pose.x_m + range_m * np.cos(heading), pose.y_m + range_m * np.sin(heading)
    colours = _floor_colours(floor, x_m, y_m) * np.asarray(tint, np.float32)
    for shadow in shadows:
        distance = np.hypot(x_m - shadow.x_m, y_m - shadow.y_m) - shadow.radius_m
        colours *= (1.0 - shadow.depth / (1.0 + np.exp(np.clip(8.0 * distance / shadow.soft_m, -30.0, 30.0))))[..., None]
    labels = np.zeros(angle.shape, np.int8)
    labels[angle >= np.pi / 2], colours[angle >= np.pi / 2] = NOTHING, _WALL
    nearest = np.full(angle.shape, np.inf, np.float32)
    for number, solid in enumerate(solids, start=1):
        _cast(solid, number, pose, colours, labels, nearest)
    _draw_own_body(angle, colours, labels)
    labels[angle > HALF_FIELD_RAD], colours[angle > HALF_FIELD_RAD] = NOTHING, 0.0
    light = exposure * (1.0 - vignetting * (angle / np.float32(HALF_FIELD_RAD)) ** 2)
    return Rendering(_develop(colours * light[..., None], noise, seed), _coarse_labels(labels))


@cache
def _rays() -> tuple[Field, Field, Field]:
    """Return every ray's angle to the axis [rad], bearing [rad; body] and where it meets the floor [m from the robot, at most 100]."""
    u, v = ((np.arange(size * _FINE) + 0.5) / _FINE - 0.5 for size in (WIDTH_PX, HEIGHT_PX))
    left, ahead = np.meshgrid(CENTRE_PX[0] - u, CENTRE_PX[1] - v)
    angle = np.hypot(left, ahead) / FOCAL_PX
    range_m = np.where(angle < np.pi / 2, np.minimum(CAMERA_HEIGHT_M * np.tan(np.minimum(angle, np.pi / 2)), 100.0), 100.0)
    return angle.astype(np.float32), np.arctan2(left, ahead).astype(np.float32), range_m.astype(np.float32)


@cache
def _levels() -> tuple[NDArray[np.int32], Field]:
    """Return for every ray the level of the atlas whose cells are about as large as what the ray covers, and that level's shrinkage."""
    angle, _, range_m = _rays()
    step_rad = 1.0 / (FOCAL_PX * _FINE)
    along = CAMERA_HEIGHT_M * step_rad / np.maximum(np.cos(angle), 1e-2) ** 2
    across = range_m * step_rad / np.maximum(angle, 1e-3)
    level = np.clip(np.round(np.log2(np.sqrt(along * across) / CELL_M)), 0, 5).astype(np.int32)
    return level, (0.5**level).astype(np.float32)


def _floor_colours(floor: str, x_m: Field, y_m: Field) -> Field:
    level, shrink = _levels()
    size = SIDE_CELLS * shrink
    row, col = (np.clip((at / CELL_M + SIDE_CELLS / 2) * shrink - 0.5, 0.0, size - 1.0).astype(np.float32) for at in (x_m, y_m))
    first_row = np.where(level > 0, SIDE_CELLS - 2 * size, 0.0)  # the levels below the first lie one under the other, to its right
    sampled = cv2.remap(
        floor_atlas(floor), col + np.where(level > 0, np.float32(SIDE_CELLS), np.float32(0)), row + first_row, cv2.INTER_LINEAR
    )
    return sampled.astype(np.float32)


def _cast(solid: Box | Cylinder, number: int, pose: Pose2, colours: Field, labels: NDArray[np.int8], nearest: Field) -> None:
    """Draw one solid where it is nearer than what was drawn before; distances are measured along the floor."""
    angle, bearing, range_m = _rays()
    centre = pose.inverse().apply((solid.x_m, solid.y_m))
    width = np.arcsin(min(solid.reach_m / float(np.hypot(*centre)), 1.0))
    off = np.abs(np.remainder(bearing - np.arctan2(centre[1], centre[0]) + np.pi, 2 * np.pi) - np.pi)
    rays = np.flatnonzero((off <= width) & (angle < HALF_FIELD_RAD))
    enter, leave, normal = solid.span(pose, bearing.ravel()[rays])
    slope = np.tan(np.clip(angle.ravel()[rays], 1e-4, np.pi / 2 - 1e-4))  # way along the floor for each metre down
    under_top = (CAMERA_HEIGHT_M - solid.height_m) * slope
    at = np.maximum(enter, under_top)
    hit = (at < np.minimum(leave, range_m.ravel()[rays])) & (at < nearest.ravel()[rays])
    on_top = (under_top > enter)[..., None]
    side = np.asarray(solid.colour, np.float32) * (0.72 + 0.22 * np.cos(normal - _LIGHT_RAD))[:, None]
    top = np.broadcast_to(np.asarray(solid.colour, np.float32), side.shape)
    if isinstance(solid, Cylinder) and solid.rim:
        heading = bearing.ravel()[rays]
        from_centre = np.hypot(at * np.cos(heading) - centre[0], at * np.sin(heading) - centre[1])
        top = np.where((from_centre > solid.reach_m - _RIM_WIDTH_M)[:, None], np.asarray(_RIM, np.float32), top)
    shaded, rays = np.where(on_top, top, side)[hit], rays[hit]
    colours.reshape(-1, 3)[rays] = shaded
    labels.reshape(-1)[rays], nearest.reshape(-1)[rays] = number, at[hit]


def _draw_own_body(angle: Field, colours: Field, labels: NDArray[np.int8]) -> None:
    from_axis = np.where(angle < 1.5, np.tan(angle), np.inf) * (CAMERA_HEIGHT_M - BODY_HEIGHT_M)
    own, deck = from_axis <= BODY_RADIUS_M, from_axis <= BODY_RADIUS_M - _RIM_WIDTH_M
    colours[own], labels[own] = _RIM, OWN_BODY
    colours[deck] = _DECK


def _develop(light: Field, noise: float, seed: int) -> NDArray[np.uint8]:
    picture = cv2.resize(light.astype(np.float32), (WIDTH_PX, HEIGHT_PX), interpolation=cv2.INTER_AREA)
    grain = np.random.default_rng(seed).standard_normal(picture.shape, dtype=np.float32)
    return np.asarray(np.clip(np.rint(picture + np.float32(noise) * grain), 0, 255), np.uint8)


def _coarse_labels(fine: NDArray[np.int8]) -> NDArray[np.int8]:
    """Return one label for each pixel: the label of a ray in it that is not FLOOR, if there is any."""
    blocks = fine.reshape(HEIGHT_PX, _FINE, WIDTH_PX, _FINE)
    highest, lowest = blocks.max(axis=(1, 3)), blocks.min(axis=(1, 3))
    return np.asarray(np.where(highest > FLOOR, highest, lowest), np.int8)
