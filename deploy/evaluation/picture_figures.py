"""Figures laid out from the pictures that the agents drew during the run: one view of one robot, or four views in a panel."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from deploy.evaluation.style import framed_figure
from protocol.errors import RecordingError

CAPTIONS = {
    "labels": "what is left of the picture once the floor is removed, labelled, before the connection algorithm",
    "connected": "obstacle candidates, which are the labels after the connection algorithm",
    "vectors": "motion vectors of the corners by Lucas-Kanade optical flow, in the uncorrected picture",
    "corrected": "motion vectors with their ends corrected for the lens, on the floor",
    "hulls": "corrected points, and the outline of each label on the floor, which for the paper is their convex hull",
}
VIEW_FIGURES = ((4, "labels"), (5, "connected"), (6, "vectors"), (8, "corrected"), (9, "hulls"))
PANEL_VIEWS = ("connected", "vectors", "corrected", "local_map")
PANEL_TITLES = ("labelling", "motion vectors", "corrected vectors", "local map")

_WIDTH_IN = 8.0


def view_figure(picture: Path, number: int, view: str, robot: str, label: str) -> Figure:
    """Return one view of one robot, as large as the page."""
    pixels = _read_picture(picture)
    height_in = _WIDTH_IN * pixels.shape[0] / pixels.shape[1] + 0.6
    title = f"Fig. {number}   {view}, {robot}"
    figure = framed_figure(title, f"{label}: {CAPTIONS[view]}.", (_WIDTH_IN, height_in))
    _show(figure.add_subplot(), pixels)
    return figure


def panel_figure(pictures: Sequence[Path], number: int, robot: str, label: str) -> Figure:
    """Return the four views of one robot that the paper shows of each experiment; `pictures` in the order of PANEL_VIEWS."""
    title = f"Fig. {number}   experiment result of {robot}"
    figure = framed_figure(title, f"{label}: from the picture to the local map.", (_WIDTH_IN, 0.75 * _WIDTH_IN + 0.9))
    axes = figure.subplots(2, 2)
    for place, picture, name in zip(axes.flat, pictures, PANEL_TITLES, strict=True):
        _show(place, _read_picture(picture))
        place.set_title(name)
    return figure


def _read_picture(file: Path) -> NDArray[np.uint8]:
    """Return a picture, shape (rows, columns, 3), red first."""
    bgr = cv2.imread(str(file), cv2.IMREAD_COLOR)
    if bgr is None:
        raise RecordingError(f"{file}: is no picture")
    return np.asarray(bgr[:, :, ::-1], dtype=np.uint8)


def _show(axes: Axes, pixels: NDArray[np.uint8]) -> None:
    axes.imshow(pixels, interpolation="antialiased")
    axes.set(xticks=(), yticks=())
    axes.spines[:].set_visible(False)
