"""What stands around the robot: every region with its outline on the floor, its motion, and its height where parallax has told it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from agent.slam.base_line import SURE_CORNERS, Rig, base_share
from agent.slam.feature_tracks import Tracks, heights
from agent.slam.floor_marks import is_mark
from agent.slam.region_labels import LAST_LABEL
from agent.slam.splitting import Corners, cut, split
from agent.vision.connection import WALL_RAD
from agent.vision.floor_projection import FloorProjection
from agent.vision.floor_view import FloorView
from agent.vision.hull import centre_of_polygon, convex_hull, overlap
from agent.vision.outlines import Borders, floor_outlines, signed_area
from agent.vision.robust import quantile
from protocol.geometry import Array

MOVING_SHARE = 0.5  # of a region's corners, of those that can tell
SETTLED_SIGMA = 0.05  # a slope known to this tells the height to 2.5 cm for a camera half a metre high
FLAT_SLOPE = 0.02  # a height of a fiftieth of the camera's: less is paint, shadow or light
FLAT_CORNERS = 5
LEAST_OUTLINE_POINTS = 3
MOST_HIDDEN = 0.1  # of a base, by other things: what is hidden more than that does not blend into the floor


LiesFlat = Callable[[Array], bool | None]  # of an outline (n, 2) [body]


@dataclass(frozen=True, eq=False)
class SeenRegion:
    """One region of one frame."""

    label: int
    outline_m: Array  # (n, 2) [body], counter-clockwise
    centre_m: Array  # (2,) object centre of Eq. 8, of the outline
    motion: Literal["static", "moving", "unknown"]
    height_m: float | None  # of its highest corners
    flat: bool  # lies in the floor: a marking, a patch of light, a shadow that stays


class _Sight(NamedTuple):
    """What else is in view of a thing."""

    eye: Array  # (2,) [body]
    rig: Rig
    others: list[Array]  # (n, 2) [m; body] each, convex: the outlines of other things


def describe(
    borders: Borders, labels: NDArray[np.int32], lies_flat: LiesFlat, tracks: Tracks, view: FloorView, projection: FloorProjection
) -> list[SeenRegion]:
    """Return the regions of a frame, in the order of their borders, given their labels, (regions,), and the corners followed on them.

    `lies_flat` tells of an outline whether all within it lies in the floor, None where that is not known: then its shape has to tell.
    A wall that goes round the robot is no convex thing: its outline stays as it was seen. A region of which no area is left on the floor,
    since it lies at the rim of what can be seen, or is cut too thin, is left out.
    """
    slope, sigma = tracks.slopes()
    moving, settled = tracks.moving(), tracks.settled(SETTLED_SIGMA)
    eye, rig = projection.body_from_camera[:2, 3], Rig(projection.camera_height_m, view.body_range_m, view.body_radius_m)
    appearance = projection.floor_from_pixels(view.camera_pixels(tracks.pixels)) - eye
    described: list[SeenRegion] = []
    outlines = floor_outlines(borders, view, projection)
    whole = [outline for outline, compact in zip(outlines, borders.compact, strict=True) if compact]
    for outline, label, border, compact in zip(outlines, labels, borders.pixels, borders.compact, strict=True):
        own = tracks.labels == label
        motion = _motion(int((own & moving).sum()), int((own & settled).sum()))
        telling = own & settled
        if motion == "unknown" and _is_floor(outline, eye, rig, lies_flat):
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
            others = [other for other in whole if other is not outline]
            described += _standing(int(label), outline, corners, _Sight(eye, rig, others))
    return [region for region in described if len(region.outline_m) >= LEAST_OUTLINE_POINTS]


def _is_floor(outline: Array, eye: Array, rig: Rig, lies_flat: LiesFlat) -> bool:
    """Tell whether a region without corners is none of the things: proven to lie flat, or else as slight as grain."""
    flat = lies_flat(outline) if len(outline) >= LEAST_OUTLINE_POINTS else None
    return is_mark(outline - eye, rig.camera_height_m) if flat is None else flat


def _goes_round(border: NDArray[np.int32], view: FloorView) -> bool:
    """Tell whether a border, (n, 2) u, v [view px], is seen in a wide range of directions."""
    bearing = np.sort(view.bearing_rad[border[:, 1], border[:, 0]])
    widest_gap = float(np.diff(bearing, append=bearing[:1] + 2.0 * np.pi).max())
    return 2.0 * np.pi - widest_gap > WALL_RAD


def _standing(label: int, outline: Array, corners: Corners, sight: _Sight) -> list[SeenRegion]:
    """Return the one or two things, one behind the other, that a static outline shows, given its corners of known height."""
    parted = split(corners, sight.rig.camera_height_m)
    if parted is None:
        return [_static(label, outline, corners, sight)]
    front, behind = cut(outline, sight.eye, parted.range_m)
    parts = [(label, front, corners.select(~parted.behind)), (2 * LAST_LABEL + 1 - label, behind, corners.select(parted.behind))]
    return [_static(name, convex_hull(part), own, sight) for name, part, own in parts if len(part) >= LEAST_OUTLINE_POINTS]


def _static(label: int, outline: Array, corners: Corners, sight: _Sight) -> SeenRegion:
    """Return a thing that stands, down to its base unless that is hidden behind another thing."""
    height_m = _height(corners.slopes, sight.rig.camera_height_m)
    share = base_share(np.hypot(*(outline - sight.eye).T), corners, sight.rig)
    whole = outline if share == 1.0 else _down_to_base(outline, share, sight)
    return SeenRegion(label, whole, centre_of_polygon(whole), "static", height_m, flat=False)


def _down_to_base(outline: Array, share: float, sight: _Sight) -> Array:
    """Return the outline, (n, 2) [m; body], with the base that begins at a share of its range, unless another thing hides that."""
    base = convex_hull(sight.eye + share * (outline - sight.eye))
    is_hidden = any(overlap(base, other) > MOST_HIDDEN * signed_area(base) for other in sight.others)
    return outline if is_hidden else convex_hull(np.concatenate([outline, base]))


def _motion(moving: int, static: int) -> Literal["static", "moving", "unknown"]:
    if moving + static < SURE_CORNERS:
        return "unknown"
    return "moving" if moving > MOVING_SHARE * (moving + static) else "static"


def _height(slopes: Array, camera_height_m: float) -> float | None:
    """Return the height of the upper corners: the tenth highest in a hundred, so that one wrong corner does not count."""
    if len(slopes) < SURE_CORNERS:
        return None
    return max(0.0, float(heights(np.array([quantile(slopes, 0.1)]), camera_height_m)[0]))


def _flat(slopes: Array, sigmas: Array) -> bool:
    """Tell whether no corner stands above the floor, and the corners are known well enough to say so."""
    sure = sigmas < FLAT_SLOPE / 2.0
    return int(sure.sum()) >= FLAT_CORNERS and quantile(np.abs(slopes[sure]), 0.9) < FLAT_SLOPE
