"""The paper's own method and nothing else (its section III), so that every gain is measured against it.

Where the paper leaves a choice open, it is made in its favour: flow starts from where the wheels predict, and the calibrated camera height
and the pose of the camera are used.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import cv2
import numpy as np
from numpy.typing import NDArray

from agent.geometry import calibrated_projection
from agent.pipeline import StageTimer, Step
from agent.reports import Frame, Surroundings, local_map, motion_summary
from agent.rig import Body, Calibration
from agent.slam.ego_motion import Motion
from agent.slam.odometry import WheelGeometry, WheelNoise, euler_motion, motion_covariance
from agent.slam.paper_objects import describe, static_translation, tell_robots
from agent.view import View, make_view
from agent.vision.corners import PAPER, find_corners
from agent.vision.floor_projection import FloorProjection
from agent.vision.floor_removal import FloorColours, FloorRemoval
from agent.vision.floor_view import Picture, make_floor_view
from agent.vision.flow import FlowParameters, lucas_kanade
from agent.vision.labels import Regions, label_regions
from agent.vision.motion_vectors import MotionVectors, correct_vectors, no_vectors, predict_ends
from agent.vision.rejection import RejectionLimits, consistent_vectors
from agent.wheel_history import WheelState
from protocol.geometry import Array, Pose2
from protocol.messages import LocalMap, RigValue

LEAST_BLOB_PX = 25  # of the view; smaller blobs are noise
FLOW = FlowParameters(window_px=21)
REJECTION = RejectionLimits(min_spread=0.005, min_angle_spread_rad=0.1)


@dataclass(frozen=True, eq=False)
class _Last:
    """The frame before, in which corners were found."""

    grey: Picture
    corners_px: Array  # (n, 2)
    labels: NDArray[np.int32]  # (n,)


class PaperMethod:
    """The state of one robot, from frame to frame. `projection` corrects points: by the hemispherical model, or by the calibrated lens."""

    def __init__(
        self, robot: str, epoch: int, body: Body, calibration: Calibration, projection: FloorProjection, timer: StageTimer
    ) -> None:
        self._robot, self._epoch, self._seq = robot, epoch, 0
        self._timer = timer
        self._projection = projection
        size_px = (calibration.width_px, calibration.height_px)
        self._floor_view = make_floor_view(calibrated_projection(calibration), size_px, body.body_radius_m, body.body_height_m)
        self._removal = FloorRemoval(self._floor_view, projection.camera_height_m)
        self._colours: FloorColours | None = None
        self._wheels = WheelGeometry(body.wheel_radius_m, body.wheel_base_m)
        self._angles_rad: Array | None = None
        self._odom_from_body = Pose2.identity()
        self._last: _Last | None = None
        self._show: Callable[[], View] | None = None

    @property
    def view(self) -> View | None:
        """What was seen in the last picture, laid out only when somebody asks."""
        return None if self._show is None else self._show()

    @property
    def wheel_lag_s(self) -> float:
        """The paper takes stamps as they are."""
        return 0.0

    @property
    def rig(self) -> tuple[RigValue, ...]:
        """The paper takes the rig as drawn."""
        return ()

    def step(self, stamp_ns: int, picture: NDArray[np.uint8] | None, wheels: WheelState) -> Step:
        """Take one frame; see `Pipeline.step`."""
        frame = Frame(self._robot, self._epoch, self._seq, stamp_ns)
        self._seq += 1
        turned = np.zeros(2) if self._angles_rad is None else wheels.angles_rad - self._angles_rad
        self._angles_rad = wheels.angles_rad
        predicted = euler_motion(turned, self._wheels)
        stage = self._timer.stage
        if picture is None:
            self._last = None
            motion, (vectors, kept) = self._moved(predicted, turned), no_vectors()
            return Step(self._message(frame, motion, None), motion_summary(frame, vectors, kept))
        with stage("floor"):
            grey = np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY), dtype=np.uint8)
            mask, self._colours = self._removal.remove(self._floor_view.reduce(picture), self._colours)
        with stage("labels"):
            regions = label_regions(mask, LEAST_BLOB_PX)
        with stage("vectors"):
            vectors, kept = self._flow(grey, predicted)
        with stage("motion"):
            translation = static_translation(vectors.select(kept), predicted)
            motion = self._moved(Pose2(translation[0], translation[1], predicted.theta_rad), turned)
        with stage("corners"):
            self._last = self._find_corners(grey, regions)
        with stage("report"):
            moving = tell_robots(vectors.select(kept), motion.previous_from_body)
            objects = describe(self._last.corners_px, self._last.labels, moving, self._projection, self._floor_view.reach_m)
            labelled = regions.corners_px, np.arange(1, len(regions) + 1, dtype=np.int32)
            self._show = partial(make_view, stamp_ns, picture, mask, self._floor_view, labelled, (vectors, kept), objects, [])
            seen = Surroundings(self._floor_view.reach_m, objects, [])
            return Step(self._message(frame, motion, seen), motion_summary(frame, vectors, kept))

    def _moved(self, previous_from_body: Pose2, turned: Array) -> Motion:
        self._odom_from_body = self._odom_from_body @ previous_from_body
        covariance = motion_covariance(turned, self._wheels, WheelNoise())
        return Motion(self._odom_from_body, previous_from_body, covariance, from_floor=False)

    def _flow(self, grey: Picture, predicted: Pose2) -> tuple[MotionVectors, NDArray[np.bool_]]:
        """Return the corrected motion vectors of the last frame's corners, and which, (n,), are not misrecognised."""
        if self._last is None:
            return no_vectors()
        starts = self._last.corners_px
        expected = predict_ends(starts, predicted, self._projection, self._floor_view.reach_m)
        flow = lucas_kanade(self._last.grey, grey, starts, expected, FLOW)
        vectors = correct_vectors(starts, flow.ends_px, self._last.labels, self._projection)
        return vectors, flow.kept & consistent_vectors(vectors.vectors_m, vectors.labels, REJECTION)

    def _find_corners(self, grey: Picture, regions: Regions) -> _Last:
        """Find the corners of everything that is not floor."""
        view = self._floor_view
        whole = np.zeros(grey.shape, np.uint8)
        rows, cols = (slice(part.start * view.scale, part.stop * view.scale) for part in view.crop)
        labelled = (regions.image > 0).astype(np.uint8)
        whole[rows, cols] = cv2.resize(labelled, (cols.stop - cols.start, rows.stop - rows.start), interpolation=cv2.INTER_NEAREST)
        corners = find_corners(grey, PAPER, whole)
        return _Last(grey, corners, regions.labels_at(view.view_pixels(corners)))

    def _message(self, frame: Frame, motion: Motion, seen: Surroundings | None) -> LocalMap:
        return local_map(frame, motion, seen, self._floor_view.body_range_m, self._projection.camera_height_m)
