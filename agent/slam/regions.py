"""What stands around the robot: every region with its outline on the floor, its motion, and its height where parallax has told it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from agent.slam.feature_tracks import Tracks, heights
from agent.slam.region_labels import LAST_LABEL
from agent.slam.splitting import Corners, cut, split
from agent.vision.connection import WALL_RAD
from agent.vision.floor_projection import FloorProjection
from agent.vision.floor_view import FloorView
from agent.vision.hull import centre_of_polygon, convex_hull
from agent.vision.outlines import Borders, floor_outlines
from agent.vision.robust import median
from protocol.geometry import Array

MOVING_SHARE = 0.5  # of a region's corners, of those that can tell
SURE_CORNERS = 3
SETTLED_SIGMA = 0.05  # a slope known to this tells the height to 2.5 cm for a camera half a metre high
FLAT_SLOPE = 0.02  # a height of a fiftieth of the camera's: less is paint, shadow or light
FLAT_CORNERS = 5
NEAR_SHARE = 0.25  # of a region's depth: corners this near to its near border belong to that
LEAST_OUTLINE_POINTS = 3
LEAST_BASE_SHARE = 0.6  # of the border's range, at which its base may lie: the border is then at 0.4 camera heights
MARK_REACH, MARK_WIDTH, MARK_HEIGHT = 1.0, 0.1, 0.25  # of the camera's height: so near a floor's grain shows, so narrow and low as things
STREAK_WIDTH, STREAK_HEIGHT = 0.04, 0.5  # and what is narrower than this would be as tall
AFLOAT_SLOPE = -0.1  # corners with a slope below this stand a tenth of the camera's height above the floor, and more


class Rig(NamedTuple):
    """What of the camera and the body tells where things can stand."""

    camera_height_m: float
    body_range_m: float  # nothing stands nearer


@dataclass(frozen=True, eq=False)
class SeenRegion:
    """One region of one frame."""

    label: int
    outline_m: Array  # (n, 2) [body], counter-clockwise
    centre_m: Array  # (2,) object centre of Eq. 8, of the outline
    motion: Literal["static", "moving", "unknown"]
    height_m: float | None  # of its highest corners
    flat: bool  # lies in the floor: a marking, a patch of light, a shadow that stays


def describe(borders: Borders, labels: NDArray[np.int32], tracks: Tracks, view: FloorView, projection: FloorProjection) -> list[SeenRegion]:
    """Return the regions of a frame, in the order of their borders, given their labels, (regions,), and the corners followed on them.

    A wall that goes round the robot is no convex thing: its outline stays as it was seen. A region of which no area is left on the floor,
    since it lies at the rim of what can be seen, or is cut too thin, is left out.
    """
    slope, sigma = tracks.slopes()
    moving, settled = tracks.moving(), tracks.settled(SETTLED_SIGMA)
    eye, rig = projection.body_from_camera[:2, 3], Rig(projection.camera_height_m, view.body_range_m)
    appearance = projection.floor_from_pixels(view.camera_pixels(tracks.pixels)) - eye
    described: list[SeenRegion] = []
    outlines = floor_outlines(borders, view, projection)
    for outline, label, border, compact in zip(outlines, labels, borders.pixels, borders.compact, strict=True):
        own = tracks.labels == label
        motion = _motion(int(moving[own].sum()), int(settled[own].sum()))
        telling = own & settled
        if motion == "unknown" and _is_mark(outline, eye, rig):
            described.append(SeenRegion(int(label), outline, centre_of_polygon(outline), motion, None, flat=True))
        elif motion != "static":
            described.append(SeenRegion(int(label), outline, centre_of_polygon(outline), motion, None, flat=False))
        elif _flat(slope[telling], sigma[telling]):
            described.append(SeenRegion(int(label), outline, centre_of_polygon(outline), motion, 0.0, flat=True))
        elif not compact and _goes_round(border, view):
            height_m = _height(slope[telling], rig.camera_height_m)
            described.append(SeenRegion(int(label), outline, centre_of_polygon(outline), motion, height_m, flat=False))
        else:
            corners = Corners(appearance[telling], slope[telling])
            described += _standing(int(label), outline, corners, eye, rig)
    return [region for region in described if len(region.outline_m) >= LEAST_OUTLINE_POINTS]


def _goes_round(border: NDArray[np.int32], view: FloorView) -> bool:
    """Tell whether a border, (n, 2) u, v [view px], is seen in a wide range of directions."""
    bearing = np.sort(view.bearing_rad[border[:, 1], border[:, 0]])
    widest_gap = float(np.diff(bearing, append=bearing[:1] + 2.0 * np.pi).max())
    return 2.0 * np.pi - widest_gap > WALL_RAD


def _standing(label: int, outline: Array, corners: Corners, eye: Array, rig: Rig) -> list[SeenRegion]:
    """Return the one or two things, one behind the other, that a static outline shows, given its corners of known height."""
    parted = split(corners, rig.camera_height_m)
    if parted is None:
        return [_static(label, outline, corners, eye, rig)]
    front, behind = cut(outline, eye, parted.range_m)
    parts = [(label, front, corners.select(~parted.behind)), (2 * LAST_LABEL + 1 - label, behind, corners.select(parted.behind))]
    return [_static(name, convex_hull(part), own, eye, rig) for name, part, own in parts if len(part) >= LEAST_OUTLINE_POINTS]


def _static(label: int, outline: Array, corners: Corners, eye: Array, rig: Rig) -> SeenRegion:
    whole = _down_to_floor(outline, eye, corners, rig.body_range_m)
    return SeenRegion(label, whole, centre_of_polygon(whole), "static", _height(corners.slopes, rig.camera_height_m), flat=False)


def _motion(moving: int, static: int) -> Literal["static", "moving", "unknown"]:
    if moving + static < SURE_CORNERS:
        return "unknown"
    return "moving" if moving > MOVING_SHARE * (moving + static) else "static"


def _height(slopes: Array, camera_height_m: float) -> float | None:
    """Return the height of the upper corners: the tenth highest in a hundred, so that one wrong corner does not count."""
    if len(slopes) < SURE_CORNERS:
        return None
    return max(0.0, float(heights(np.array([np.quantile(slopes, 0.1)]), camera_height_m)[0]))


def _flat(slopes: Array, sigmas: Array) -> bool:
    """Tell whether no corner stands above the floor, and the corners are known well enough to say so."""
    sure = sigmas < FLAT_SLOPE / 2.0
    return int(sure.sum()) >= FLAT_CORNERS and bool(np.quantile(np.abs(slopes[sure]), 0.9) < FLAT_SLOPE)


def _is_mark(outline: Array, eye: Array, rig: Rig) -> bool:
    """Tell whether an outline, (n, 2) [m; body], is like the grain of a floor: near, narrow, and too short to be the image of a tall thing.

    The image of an upright thing of height h that begins at a distance r from the eye, (2,), ends no nearer than r / (1 - h / H), with H
    the camera's height.
    """
    away = outline - eye
    reach = np.hypot(*away.T)
    ahead = away.mean(axis=0) / np.hypot(*away.mean(axis=0))
    width = np.ptp(away @ np.array([-ahead[1], ahead[0]]))
    is_near = reach.max() < MARK_REACH * rig.camera_height_m
    tallest = STREAK_HEIGHT if width < STREAK_WIDTH * rig.camera_height_m else MARK_HEIGHT
    return bool(is_near and width < MARK_WIDTH * rig.camera_height_m and 1.0 - reach.min() / reach.max() < tallest)


def _down_to_floor(outline: Array, eye: Array, corners: Corners, least_range_m: float) -> Array:
    """Return the outline, (n, 2) [m; body], of the whole thing where only its upper part was told from the floor.

    If all corners, some of them at its near border, surely stand above the floor, so does the border, and the base is nearer to the eye,
    (2,), by the stretch of those at the border. A base that would lie much nearer, or under the own body, is not believed.
    """
    reach = np.hypot(*(outline - eye).T)
    near, far = float(reach.min()), float(reach.max())
    border = corners.slopes[np.hypot(*corners.appearances_m.T) < near + NEAR_SHARE * (far - near)]
    if not len(border) or len(corners.slopes) < SURE_CORNERS or corners.slopes.max() > AFLOAT_SLOPE:
        return outline
    share = 1.0 / (1.0 - float(median(border)))
    if share < LEAST_BASE_SHARE or share * near < least_range_m:
        return outline
    base = eye + (outline - eye) * share
    return convex_hull(np.concatenate([outline, base]))
