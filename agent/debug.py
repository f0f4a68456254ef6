"""Pictures of what the agent sees, in the manner of the paper's Fig. 4, 5, 6, 8, 9 and 15 to 17: a View in, a BGR picture out."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

import cv2
import numpy as np
from numpy.typing import NDArray

from agent.canvas import Canvas, FloorSheet
from agent.view import View
from protocol.errors import GeometryError
from protocol.geometry import Array

Picture = NDArray[np.uint8]

# BGR
_RED = (40, 30, 215)
_GREEN = (75, 175, 40)
_ORANGE = (20, 135, 240)
_BLUE = (190, 110, 30)
_GREY = (150, 150, 150)
_KIND_COLOURS = MappingProxyType({"static": _GREEN, "moving": _ORANGE, "unknown": _GREY})

_FLOOR_SHADE = 0.45  # brightness that is left of the floor where labels are shown
_MIN_REACH_M, _MAX_REACH_M, _REACH_STEP_M = 1.0, 3.0, 0.5
_DOT_PX = 4.0


def labels(view: View) -> Picture:
    """Draw what is not floor, and the labels before the connection algorithm (Fig. 4)."""
    canvas = Canvas(_without_floor(view))
    for rectangle in view.rectangles_before:
        canvas.rectangle(rectangle, _GREEN)
    return canvas.captioned(f"{len(view.rectangles_before)} labels before connection")


def connected(view: View) -> Picture:
    """Draw the labels after the connection algorithm, with their numbers (Fig. 5)."""
    canvas = Canvas(_without_floor(view))
    for border in view.borders_px:
        canvas.polygon(border, _GREEN)
    for border, label in zip(view.borders_px, view.labels, strict=True):
        canvas.tag(str(label), border[border[:, 1].argmin()], _GREEN)
    return canvas.captioned(f"{len(view.labels)} labels after connection")


def vectors(view: View) -> Picture:
    """Draw the motion vectors on the picture: kept ones as red arrows, misrecognised ones in grey (Fig. 6)."""
    canvas = Canvas(view.picture.copy())
    for wanted, colour in ((False, _GREY), (True, _RED)):
        chosen = view.kept == wanted
        for start, end in zip(view.starts_px[chosen], view.ends_px[chosen], strict=True):
            canvas.arrow(start, end, colour)
    return canvas.captioned(f"{int(view.kept.sum())} motion vectors, {int((~view.kept).sum())} misrecognised")


def corrected(view: View) -> Picture:
    """Draw the kept motion vectors on the floor, corrected for the lens (Fig. 8)."""
    sheet = _floor(view)
    starts, ends = _kept_on_floor(view)
    for start, end in zip(sheet.pixels(starts), sheet.pixels(ends), strict=True):
        sheet.canvas.arrow(start, end, _RED)
    return sheet.canvas.captioned(f"{len(starts)} corrected motion vectors")


def hulls(view: View) -> Picture:
    """Draw the corrected points and the outline of each label on the floor (Fig. 9): the paper's is their convex hull."""
    sheet = _floor(view)
    outlines = [sheet.pixels(outline) for outline in view.outlines_m]
    for outline in outlines:
        sheet.canvas.polygon(outline, _GREEN)
    for end in sheet.pixels(_kept_on_floor(view)[1]):
        sheet.canvas.dot(end, _DOT_PX, _RED)
    for corner in (corner for outline in outlines for corner in outline):
        sheet.canvas.dot(corner, _DOT_PX, _GREEN)
    return sheet.canvas.captioned(f"{len(outlines)} outlines")


def local_map(view: View) -> Picture:
    """Draw the robot, what stands around it by kind, and whom it sights (Fig. 15 to 17, bottom right)."""
    sheet = _floor(view)
    for outline, kind in zip(view.outlines_m, view.kinds, strict=True):
        sheet.canvas.polygon(sheet.pixels(outline), _KIND_COLOURS[kind])
    for range_m, bearing_rad, sigma_m in view.sightings:
        place = sheet.pixels(range_m * np.array([np.cos(bearing_rad), np.sin(bearing_rad)]))
        sheet.canvas.line(sheet.pixels((0.0, 0.0)), place, _BLUE)
        sheet.canvas.ring(place, sheet.px_per_m * sigma_m, _BLUE)
        sheet.canvas.dot(place, _DOT_PX, _BLUE)
    sheet.draw_robot()
    sheet.canvas.legend([(kind, colour) for kind, colour in _KIND_COLOURS.items() if kind in view.kinds])
    return sheet.canvas.captioned("local map")


PICTURES: Mapping[str, Callable[[View], Picture]] = MappingProxyType(
    {"labels": labels, "connected": connected, "vectors": vectors, "corrected": corrected, "hulls": hulls, "local_map": local_map}
)


def png(picture: Picture) -> bytes:
    """Return a picture as PNG. Raises GeometryError where it has no pixel."""
    if not picture.size:
        raise GeometryError(f"a picture of shape {picture.shape} cannot be encoded")
    _, data = cv2.imencode(".png", picture)
    return data.tobytes()


def _without_floor(view: View) -> Picture:
    """Return the picture with its floor darkened and grey."""
    height, width = view.picture.shape[:2]
    mask = cv2.resize(view.mask, (width, height), interpolation=cv2.INTER_NEAREST)[..., None] != 0
    grey = cv2.cvtColor(cv2.cvtColor(view.picture, cv2.COLOR_BGR2GRAY), cv2.COLOR_GRAY2BGR)
    return np.where(mask, view.picture, (grey * _FLOOR_SHADE).astype(np.uint8))


def _floor(view: View) -> FloorSheet:
    """Return a sheet of floor around the robot, wide enough for what the view holds."""
    points = np.concatenate([*_kept_on_floor(view), *view.outlines_m, np.zeros((1, 2))])
    reach_m = np.ceil(np.nanmax(np.abs(points)) / _REACH_STEP_M) * _REACH_STEP_M
    sheet = FloorSheet(float(np.clip(reach_m, _MIN_REACH_M, _MAX_REACH_M)))
    sheet.draw_robot()
    return sheet


def _kept_on_floor(view: View) -> tuple[Array, Array]:
    """Return the starts and the ends, both (n, 2) [m], of the kept vectors that lie on the floor."""
    on_floor = view.kept & np.isfinite(view.starts_m).all(axis=1) & np.isfinite(view.ends_m).all(axis=1)
    return view.starts_m[on_floor], view.ends_m[on_floor]
