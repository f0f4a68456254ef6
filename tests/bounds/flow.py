"""Optical flow on a real pair of pictures whose true flow is known: RubberWhale of the Middlebury set."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from agent.vision.flow import FlowParameters, track_pyramidal
from protocol.errors import RecordingError
from protocol.geometry import Array

_UNKNOWN_PX = 1e9  # the set marks places without known flow by values beyond this
_HEADER_BYTES = 12  # magic number, width, height


def flow_figures(folder: Path) -> dict[str, float]:
    """Return the end-point errors over all Harris points with known flow; a point that was lost counts with its error like any other."""
    previous, current = (_grey(folder / f"RubberWhale{number}.png") for number in (1, 2))
    truth = _true_flow(folder / "RubberWhale.flo")
    corners = cv2.goodFeaturesToTrack(previous, 0, 0.01, 7, blockSize=3, useHarrisDetector=True, k=0.04).reshape(-1, 2).astype(np.float64)
    columns, rows = np.rint(corners).astype(np.intp).T
    known = np.abs(truth[rows, columns]).max(axis=1) < _UNKNOWN_PX
    starts, moves = corners[known], truth[rows, columns][known]
    ends = track_pyramidal(previous, current, starts, starts, FlowParameters()).ends_px
    errors_px = np.hypot(*(ends - starts - moves).T)
    return {"median_px": float(np.median(errors_px)), "mean_px": float(errors_px.mean()), "points": float(len(errors_px))}


def _grey(file: Path) -> NDArray[np.uint8]:
    picture = cv2.imread(str(file), cv2.IMREAD_GRAYSCALE)
    if picture is None:
        raise RecordingError(f"{file}: is no picture")
    return np.asarray(picture, np.uint8)


def _true_flow(file: Path) -> Array:
    """Return the flow, (rows, cols, 2) [px], of a .flo file."""
    content = file.read_bytes()
    width, height = np.frombuffer(content, np.int32, 2, offset=_HEADER_BYTES - 8)
    return np.frombuffer(content, np.float32, offset=_HEADER_BYTES).reshape(height, width, 2).astype(np.float64)
