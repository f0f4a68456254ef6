"""Our best: one frame to one local map by floor alignment, parallax and silhouettes. `FullMethod.step` reads as the list of its steps."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import cv2
import numpy as np
from numpy.typing import NDArray

from agent.geometry import calibrated_projection
from agent.pipeline import StageTimer, Step
from agent.reports import Frame, Surroundings, local_map, motion_summary
from agent.rig import Body, Calibration
from agent.slam.corner_follower import CornerFollower
from agent.slam.ego_motion import EgoMotion
from agent.slam.floor_memory import FloorMemory
from agent.slam.odometry import WheelGeometry, WheelNoise
from agent.slam.regions import describe
from agent.slam.robot_watch import RobotWatch
from agent.view import View, make_view
from agent.vision.depth_steps import cut_at_depth_steps
from agent.vision.edges import located
from agent.vision.floor_patch import FloorPatch
from agent.vision.floor_removal import FloorColours, FloorRemoval
from agent.vision.floor_view import Picture, make_floor_view
from agent.vision.motion_vectors import no_vectors
from agent.vision.outlines import Mask, find_borders, open_rings
from agent.vision.range_profile import range_profile, round_bases, tall_bases
from agent.vision.robot_fit import RobotFitter
from agent.vision.robot_outlines import parted_from_robots, shown_share
from protocol.geometry import Array

FLOOR_MARGIN_IN_HEIGHTS = 0.04  # floor this near to an object is not aligned with: its contact shadow, and the mask's own error
BASE_TOLERANCE_IN_HEIGHTS = 0.02  # by which the profile across a robot's base may differ from a circle
FLOOR_RANGE_IN_HEIGHTS = 3.4  # bare floor is vouched for to here; farther out small things are lost between pixels
DEPTH_STEP_IN_HEIGHTS = 0.15  # a leap of a region's near border by this much parts two things
LEAST_REGION_PX = 25.0  # of the view


class FullMethod:
    """The state of one robot, from frame to frame."""

    def __init__(self, robot: str, epoch: int, body: Body, calibration: Calibration, timer: StageTimer) -> None:
        self._robot, self._epoch, self._seq = robot, epoch, 0
        self._timer = timer
        projection = calibrated_projection(calibration)
        self._height_m = projection.camera_height_m
        size_px = (calibration.width_px, calibration.height_px)
        view = make_floor_view(projection, size_px, body.body_radius_m, body.body_height_m)
        self._projection, self._floor_view = projection, view
        self._removal = FloorRemoval(view, self._height_m)
        self._colours: FloorColours | None = None
        self._patch = FloorPatch(projection, view)
        self._ego = EgoMotion(self._patch, WheelGeometry(body.wheel_radius_m, body.wheel_base_m), WheelNoise())
        self._corners = CornerFollower(view, projection, view.scale / float(np.mean(calibration.focal_px)))
        self._body = body
        fitter = RobotFitter(projection, body.body_radius_m, body.body_height_m)
        self._eye_m = projection.body_from_camera[:2, 3]
        self._memory = FloorMemory(self._patch, view.body_range_m, body.body_radius_m, self._eye_m)
        self._watch = RobotWatch(fitter, body.body_radius_m, self._eye_m)
        self._show: Callable[[], View] | None = None

    @property
    def view(self) -> View | None:
        """What was seen in the last picture, laid out only when somebody asks."""
        return None if self._show is None else self._show()

    def step(self, stamp_ns: int, picture: NDArray[np.uint8] | None, wheel_angles_rad: Array) -> Step:
        """Take one frame; see `Pipeline.step`."""
        frame = Frame(self._robot, self._epoch, self._seq, stamp_ns)
        self._seq += 1
        if picture is None:
            return self._blind_step(frame, wheel_angles_rad)
        stage = self._timer.stage
        with stage("reduce"):
            grey, reduced, small = self._reduce(picture)
        with stage("floor"):
            mask, self._colours = self._removal.remove(reduced, self._colours)
        with stage("motion"):
            bare = self._patch.bare(mask, FLOOR_MARGIN_IN_HEIGHTS * self._height_m)
            floor = self._patch.sample(grey)
            motion = self._ego.advance(wheel_angles_rad, self._patch.texture(floor), bare)
        with stage("vectors"):
            vectors, kept = self._corners.follow(small, motion.odom_from_body)
        with stage("labels"):
            expected_m = self._watch.expected_m(motion.odom_from_body)
            parted = self._parted(mask, expected_m)
            rough = find_borders(parted, self._floor_view.nadir_px, LEAST_REGION_PX)
            borders = located(rough, parted, self._floor_view, reduced)
            labels = self._corners.label(borders, motion.odom_from_body)
            flat = partial(self._memory.lies_flat, cells=floor, odom_from_body=motion.odom_from_body)
            regions = describe(borders, labels, flat, self._corners.tracks, self._floor_view, self._projection)
            self._memory.remember(floor, expected_m, motion.odom_from_body)
        with stage("robots"):
            profile = range_profile(borders, self._floor_view, self._eye_m)
            bases = round_bases(profile, self._body.body_radius_m, BASE_TOLERANCE_IN_HEIGHTS * self._height_m)
            tall = tall_bases(bases, self._body.body_height_m, borders, self._floor_view, self._projection)
            robots = self._watch.look(grey, motion.odom_from_body, tall, self._shown_in(mask))
        with stage("report"):
            self._show = partial(make_view, stamp_ns, picture, mask, self._floor_view, (vectors, kept), regions, robots)
            seen = Surroundings(FLOOR_RANGE_IN_HEIGHTS * self._height_m, regions, robots)
            reported = local_map(frame, motion, seen, self._floor_view.body_range_m, self._height_m)
            return Step(reported, motion_summary(frame, vectors, kept))

    def _blind_step(self, frame: Frame, wheel_angles_rad: Array) -> Step:
        """Take one step without a picture: the wheels alone, and nothing seen."""
        motion = self._ego.advance_blind(wheel_angles_rad)
        self._corners.forget()
        vectors, kept = no_vectors()
        reported = local_map(frame, motion, None, self._floor_view.body_range_m, self._height_m)
        return Step(reported, motion_summary(frame, vectors, kept))

    def _shown_in(self, mask: Mask) -> Callable[[Array], float]:
        """Return how much of a robot at a place is no floor in a mask."""
        return lambda centre_m: shown_share(mask, centre_m, self._body, self._floor_view, self._projection)

    def _parted(self, mask: Mask, robots_m: Array) -> Mask:
        """Return the mask of what is not floor with a gap between things, and around the robots expected at (n, 2) [body]."""
        alone = parted_from_robots(mask, robots_m, self._body.body_radius_m, self._floor_view, self._projection)
        return cut_at_depth_steps(open_rings(alone, self._floor_view), self._floor_view, DEPTH_STEP_IN_HEIGHTS * self._height_m)

    def _reduce(self, picture: Picture) -> tuple[Picture, Picture, Picture]:
        """Return the picture in grey, reduced, and reduced in grey."""
        reduced = self._floor_view.reduce(picture)
        grey, small = (cv2.cvtColor(colour, cv2.COLOR_BGR2GRAY) for colour in (picture, reduced))
        return np.asarray(grey, np.uint8), reduced, np.asarray(small, np.uint8)
