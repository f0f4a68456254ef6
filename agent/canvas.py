"""What debug pictures are drawn on, with smooth lines: a canvas, in pixels, and a sheet of floor around the robot, in metres."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from protocol.geometry import Array

Picture = NDArray[np.uint8]
Colour = tuple[int, int, int]  # BGR

_FINE = 4  # lines are placed to a sixteenth of a pixel
_FONT = cv2.FONT_HERSHEY_DUPLEX
_INK: Colour = (45, 40, 40)
_PAPER: Colour = (255, 255, 255)
_GRID: Colour = (232, 230, 228)
_SIDE_PX = 960
_MARGIN_PX = 28
_GRID_M = 0.5
_ROBOT_M = 0.05  # half the length of the robot's mark
_FILL = 0.25  # opacity
_FARTHEST = 2**19  # [1/16 px]: what lies farther out is not seen anyway, and would overflow inside OpenCV


class Canvas:
    """A picture that is drawn on in place; line and letter sizes go with its width."""

    def __init__(self, picture: Picture) -> None:
        self.picture = picture
        self._unit = max(picture.shape[1] / 960.0, 0.5)
        self._stroke = max(1, round(1.5 * self._unit))

    def line(self, start: ArrayLike, end: ArrayLike, colour: Colour) -> None:
        """Draw a line between two points [px]."""
        cv2.line(self.picture, _fine(start), _fine(end), colour, self._stroke, cv2.LINE_AA, _FINE)

    def arrow(self, start: ArrayLike, end: ArrayLike, colour: Colour) -> None:
        """Draw an arrow with a dot at its start [px]; its head is never longer than itself."""
        tail, tip = np.asarray(start, dtype=np.float64), np.asarray(end, dtype=np.float64)
        length = float(np.hypot(*(tip - tail)))
        self.dot(tail, 1.6 * self._unit, colour)
        self.line(tail, tip, colour)
        if length > 0.0:
            self._head(tip, (tip - tail) / length, min(7.0 * self._unit, length), colour)

    def dot(self, centre: ArrayLike, radius: float, colour: Colour) -> None:
        """Draw a filled circle [px]."""
        cv2.circle(self.picture, _fine(centre), _fine_length(radius), colour, cv2.FILLED, cv2.LINE_AA, _FINE)

    def ring(self, centre: ArrayLike, radius: float, colour: Colour) -> None:
        """Draw a circle [px]."""
        cv2.circle(self.picture, _fine(centre), _fine_length(radius), colour, self._stroke, cv2.LINE_AA, _FINE)

    def rectangle(self, rectangle: ArrayLike, colour: Colour) -> None:
        """Draw a rectangle x, y, width, height [px]."""
        x, y, width, height = np.asarray(rectangle)
        corners = _fine_points([(x, y), (x + width, y), (x + width, y + height), (x, y + height)])
        cv2.polylines(self.picture, [corners], True, colour, self._stroke, cv2.LINE_AA, _FINE)

    def polygon(self, corners: ArrayLike, colour: Colour) -> None:
        """Draw a closed polygon (n, 2) [px], its inside lightly filled."""
        points = _fine_points(corners)
        filled = self.picture.copy()
        cv2.fillPoly(filled, [points], colour, cv2.LINE_AA, _FINE)
        cv2.addWeighted(filled, _FILL, self.picture, 1.0 - _FILL, 0.0, dst=self.picture)
        cv2.polylines(self.picture, [points], True, colour, self._stroke, cv2.LINE_AA, _FINE)

    def tag(self, text: str, corner: ArrayLike, colour: Colour) -> None:
        """Write a small white text on a coloured plate with this lower left corner [px], moved to where it does not stick out."""
        size, pad = 0.55 * self._unit, round(4 * self._unit)
        (width, height), _ = cv2.getTextSize(text, _FONT, size, 1)
        wanted = np.rint(np.asarray(corner, dtype=np.float64)).astype(int)
        limits = np.array(self.picture.shape[1::-1]) - [width + 2 * pad + 1, 1]
        x, y = np.clip(wanted, [0, height + 2 * pad], np.maximum(limits, [0, height + 2 * pad])).tolist()
        cv2.rectangle(self.picture, (x, y - height - 2 * pad), (x + width + 2 * pad, y), colour, cv2.FILLED)
        cv2.putText(self.picture, text, (x + pad, y - pad), _FONT, size, _PAPER, 1, cv2.LINE_AA)

    def legend(self, entries: Sequence[tuple[str, Colour]]) -> None:
        """Write coloured names into the upper right corner, one below the other."""
        for row, (text, colour) in enumerate(entries):
            self.tag(text, (self.picture.shape[1], (row + 1) * 30.0 * self._unit), colour)

    def captioned(self, text: str) -> Picture:
        """Return the picture with a caption in its upper left corner."""
        self.tag(text, (0, 0), _INK)
        return self.picture

    def _head(self, tip: Array, along: Array, length: float, colour: Colour) -> None:
        across = np.array([-along[1], along[0]])
        back = tip - length * along
        corners = _fine_points([tip, back + 0.4 * length * across, back - 0.4 * length * across])
        cv2.fillPoly(self.picture, [corners], colour, cv2.LINE_AA, _FINE)


class FloorSheet:
    """A square white canvas that shows the floor around the robot: the body's origin in the middle, forward (x) up, left (y) left."""

    def __init__(self, reach_m: float) -> None:
        self.canvas = Canvas(np.full((_SIDE_PX, _SIDE_PX, 3), _PAPER, dtype=np.uint8))
        self.px_per_m = 0.5 * _SIDE_PX / reach_m
        self._draw_grid(reach_m)
        self._draw_scale_bar()

    def pixels(self, places_m: ArrayLike) -> Array:
        """Return where places (..., 2) [m; body] are on the sheet, same shape [px]."""
        places = np.asarray(places_m, dtype=np.float64)
        return 0.5 * (_SIDE_PX - 1) - self.px_per_m * places[..., ::-1]

    def draw_robot(self) -> None:
        """Mark the robot as an arrow head that points forward."""
        corners = _ROBOT_M * np.array([(1.0, 0.0), (-0.8, 0.7), (-0.4, 0.0), (-0.8, -0.7)])
        cv2.fillPoly(self.canvas.picture, [_fine_points(self.pixels(corners))], _INK, cv2.LINE_AA, _FINE)

    def _draw_grid(self, reach_m: float) -> None:
        count = int(reach_m / _GRID_M)
        for at_m in _GRID_M * np.arange(-count, count + 1):
            self.canvas.line(self.pixels((-reach_m, at_m)), self.pixels((reach_m, at_m)), _GRID)
            self.canvas.line(self.pixels((at_m, -reach_m)), self.pixels((at_m, reach_m)), _GRID)

    def _draw_scale_bar(self) -> None:
        bottom = _SIDE_PX - _MARGIN_PX
        end = _MARGIN_PX + _GRID_M * self.px_per_m
        self.canvas.line((_MARGIN_PX, bottom), (end, bottom), _INK)
        for x in (_MARGIN_PX, end):
            self.canvas.line((x, bottom - 6), (x, bottom + 6), _INK)
        self.canvas.tag(f"{_GRID_M:g} m", (_MARGIN_PX, bottom - 10), _INK)


def _fine(point: ArrayLike) -> tuple[int, int]:
    """Return a point [px] as OpenCV takes it with `_FINE` fractional bits."""
    x, y = np.clip(np.rint(np.asarray(point, dtype=np.float64) * 2.0**_FINE), -_FARTHEST, _FARTHEST)
    return int(x), int(y)


def _fine_length(length: float) -> int:
    return max(1, round(length * 2.0**_FINE))


def _fine_points(points: ArrayLike) -> NDArray[np.int32]:
    """Return points (n, 2) [px] as OpenCV takes them with `_FINE` fractional bits."""
    return np.array([_fine(point) for point in np.asarray(points, dtype=np.float64)], dtype=np.int32).reshape(-1, 1, 2)
