"""What the agent saw in its last frame, kept for whoever asks for a debug picture."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from agent.slam.regions import SeenRegion
from agent.vision.floor_view import FloorView
from agent.vision.motion_vectors import MotionVectors
from agent.vision.robot_fit import RobotFit
from protocol.geometry import Array


@dataclass(frozen=True, eq=False)
class View:
    """The intermediate results of one frame, as the paper's figures show them."""

    stamp_ns: int
    picture: NDArray[np.uint8]  # (rows, cols, 3) BGR
    mask: NDArray[np.uint8]  # (rows / scale, cols / scale): 1 is not floor
    rectangles_before: NDArray[np.int32]  # (n, 4) x, y, width, height [picture px]: labels before region connection
    borders_px: list[Array]  # after it, per label (j, 2) [picture px]
    labels: NDArray[np.int32]  # (m,)
    starts_px: Array  # (k, 2) motion vectors in the picture
    ends_px: Array
    starts_m: Array  # (k, 2) the same, corrected [m; body before]
    ends_m: Array  # (k, 2) [m; body]
    vector_labels: NDArray[np.int32]  # (k,)
    kept: NDArray[np.bool_]  # (k,) not rejected
    outlines_m: list[Array]  # per region (j, 2) [m; body]
    kinds: list[str]  # per region: static, moving or unknown
    sightings: Array  # (q, 3) range [m], bearing [rad], standard deviation of the range [m]


def make_view(
    stamp_ns: int,
    picture: NDArray[np.uint8],
    mask: NDArray[np.uint8],
    floor_view: FloorView,
    labelled: tuple[list[Array], NDArray[np.int32]],
    vectors: tuple[MotionVectors, NDArray[np.bool_]],
    regions: list[SeenRegion],
    robots: list[RobotFit],
) -> View:
    """Return the view of one frame; the mask, (rows, cols) of the floor view, is laid into one of the whole picture's shape.

    `labelled` holds the border of each region, (j, 2) [view px], and its label; `vectors` all that were followed, and which are kept.
    """
    scale = floor_view.scale
    whole = np.zeros((picture.shape[0] // scale, picture.shape[1] // scale), np.uint8)
    whole[floor_view.crop] = mask
    separate = np.array([cv2.boundingRect(border) for border in cv2.findContours(whole, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)[0]])
    borders, labels = labelled
    followed, kept = vectors
    return View(
        stamp_ns=stamp_ns,
        picture=picture,
        mask=whole,
        rectangles_before=(separate.reshape(-1, 4) * scale).astype(np.int32),
        borders_px=[floor_view.camera_pixels(border) for border in borders],
        labels=labels,
        starts_px=followed.starts_px,
        ends_px=followed.ends_px,
        starts_m=followed.starts_m,
        ends_m=followed.ends_m,
        vector_labels=followed.labels,
        kept=kept,
        outlines_m=[region.outline_m for region in regions],
        kinds=[region.motion for region in regions],
        sightings=np.array([_sighting(robot) for robot in robots]).reshape(-1, 3),
    )


def _sighting(robot: RobotFit) -> tuple[float, float, float]:
    x, y = robot.centre_m
    return float(np.hypot(x, y)), float(np.arctan2(y, x)), float(np.sqrt(np.trace(robot.covariance)))
