"""Our best: one frame to one local map by floor alignment, parallax and silhouettes. `FullMethod.step` reads as the list of its steps."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import cv2
import numpy as np
from numpy.typing import NDArray

from agent.optics import Optics
from agent.pipeline import StageTimer, Step
from agent.reports import Frame, Surroundings, local_map, motion_summary
from agent.rig import Body, Calibration
from agent.slam.corner_follower import CornerFollower
from agent.slam.ego_motion import EgoMotion, Motion
from agent.slam.floor_memory import FloorMemory
from agent.slam.landmarks import Landmarks, Recognition
from agent.slam.odometry import WheelNoise
from agent.slam.regions import describe
from agent.slam.robot_watch import RobotWatch
from agent.slam.self_calibration import SelfCalibration
from agent.view import View, make_view
from agent.vision.depth_steps import cut_at_depth_steps
from agent.vision.edges import located
from agent.vision.floor_removal import FloorColours
from agent.vision.floor_view import Picture
from agent.vision.levels import Levels
from agent.vision.motion_vectors import no_vectors
from agent.vision.outlines import Mask, find_borders, open_rings
from agent.vision.range_profile import range_profile, round_bases, tall_bases
from agent.vision.robot_evidence import robot_evidence
from agent.vision.robot_fit import RobotFit
from agent.vision.robot_outlines import parted_from_robots
from agent.vision.robot_scan import RobotScan
from agent.wheel_history import WheelState
from protocol.geometry import Array
from protocol.messages import RigValue

FLOOR_MARGIN_IN_HEIGHTS = 0.04  # floor this near to an object is not aligned with: its contact shadow, and the mask's own error
BASE_TOLERANCE_IN_HEIGHTS = 0.02  # by which the profile across a robot's base may differ from a circle
FLOOR_RANGE_IN_HEIGHTS = 3.4  # bare floor is vouched for to here; farther out small things are lost between pixels
DEPTH_STEP_IN_HEIGHTS = 0.15  # a leap of a region's near border by this much parts two things
LEAST_REGION_PX = 25.0  # of the view


class FullMethod:
    """The state of one robot, from frame to frame."""

    def __init__(
        self, robot: str, epoch: int, body: Body, calibration: Calibration, timer: StageTimer, rig: SelfCalibration | None = None
    ) -> None:
        """Calibrate the rig while driving, unless there is a `rig` that does something else."""
        self._robot, self._epoch, self._seq = robot, epoch, 0
        self._timer = timer
        self._body = body
        self._rig = rig or SelfCalibration(calibration, body)
        self._optics = optics = Optics.of(calibration, body)
        self._levels = Levels(optics.view)
        self._colours: FloorColours | None = None
        self._ego = EgoMotion(optics.patch, optics.shutter, self._rig.wheels, WheelNoise())
        self._corners = CornerFollower(optics.view, optics.projection, optics.view.scale / float(np.mean(calibration.focal_px)))
        self._landmarks = Landmarks(optics.patch)
        self._memory = FloorMemory(optics.patch, optics.view.body_range_m, body.body_radius_m, optics.eye_m)
        self._scan = RobotScan(optics.projection, body.body_radius_m, body.body_height_m)
        self._watch = RobotWatch(optics.fitter, body.body_radius_m, optics.eye_m)
        self._lifts = 0
        self._last: tuple[Picture, Mask] | None = None  # grey camera picture, and what is not floor in the view
        self._show: Callable[[], View] | None = None

    @property
    def view(self) -> View | None:
        """What was seen in the last picture, laid out only when somebody asks."""
        return None if self._show is None else self._show()

    def step(self, stamp_ns: int, picture: NDArray[np.uint8] | None, wheels: WheelState) -> Step:
        """Take one frame; see `Pipeline.step`."""
        frame = Frame(self._robot, self._epoch, self._seq, stamp_ns)
        self._seq += 1
        if picture is None:
            return self._blind_step(frame, wheels)
        stage = self._timer.stage
        with stage("reduce"):
            picture = self._levels.spread(picture)
            grey, reduced, small = self._reduce(picture)
        with stage("rig"):
            self._learn_rig(grey, wheels)
        with stage("floor"):
            mask, self._colours = self._optics.removal.remove(reduced, self._colours)
        with stage("motion"):
            bare = self._optics.patch.bare(mask, FLOOR_MARGIN_IN_HEIGHTS * self._optics.height_m)
            floor = self._optics.patch.sample(grey)
            motion = self._ego.advance(wheels, self._optics.patch.texture(floor), bare)
            self._last = grey, mask
        with stage("landmarks"):
            recognition = self._recognise_place(stamp_ns, motion)
        with stage("vectors"):
            vectors, kept = self._corners.follow(small, motion.odom_from_body)
        with stage("labels"):
            expected_m = self._watch.expected_m(motion.odom_from_body)
            parted = self._parted(mask, expected_m)
            rough = find_borders(parted, self._optics.view.nadir_px, LEAST_REGION_PX)
            borders = located(rough, parted, self._optics.view, reduced)
            labels = self._corners.label(borders, motion.odom_from_body)
            flat = partial(self._memory.lies_flat, cells=floor, odom_from_body=motion.odom_from_body)
            regions = describe(borders, labels, flat, self._corners.tracks, self._optics.view, self._optics.projection)
            self._memory.remember(floor, expected_m, motion.odom_from_body)
        with stage("robots"):
            profile = range_profile(borders, self._optics.view, self._optics.eye_m)
            bases = round_bases(profile, self._body.body_radius_m, BASE_TOLERANCE_IN_HEIGHTS * self._optics.height_m)
            tall = tall_bases(bases, self._body.body_height_m, borders, self._optics.view, self._optics.projection)
            scan = partial(self._scan.bases, grey)
            judge = self._judge(grey, mask)
            robots = self._watch.look(grey, motion.odom_from_body, tall, scan, judge)
        with stage("report"):
            self._show = partial(
                make_view, stamp_ns, picture, mask, self._optics.view, (borders.edges, labels), (vectors, kept), regions, robots
            )
            seen = Surroundings(FLOOR_RANGE_IN_HEIGHTS * self._optics.height_m, regions, robots, recognition)
            reported = local_map(frame, motion, None if motion.in_doubt else seen, self._optics.view.body_range_m, self._optics.height_m)
            return Step(reported, motion_summary(frame, vectors, kept))

    @property
    def wheel_lag_s(self) -> float:
        """How much later than they were read wheel readings are stamped, as far as that is known."""
        return self._rig.wheel_lag_s

    @property
    def rig(self) -> tuple[RigValue, ...]:
        """The rig as it was found to be."""
        return self._rig.values()

    def _recognise_place(self, stamp_ns: int, motion: Motion) -> Recognition | None:
        """Go on in the map of the floor; return the place that is recognised there, and enter the newest keyframe if it has one."""
        self._landmarks.move(motion)
        glance, begun = self._ego.glance, self._ego.begun
        if glance is None or motion.in_doubt:
            return None
        if motion.lifts > self._lifts:
            self._lifts = motion.lifts
            self._landmarks.lose()
        recognition = self._landmarks.look(glance)
        if begun is not None:
            self._landmarks.enter(stamp_ns, begun, glance)
        return recognition

    def _learn_rig(self, grey: Picture, wheels: WheelState) -> None:
        """Learn what the newest picture and the last pair tell of the rig; where that contradicts the rig in use, change it."""
        self._rig.look(grey)
        self._rig.look_round(grey, wheels, self._optics.uprights, self._optics.upright_sensitivity)
        self._rig.compare(self._ego.pair, self._optics.sensitivity)
        lag_s = self._rig.wheel_lag_s
        if self._rig.adopt():
            self._change_rig(self._rig.wheel_lag_s - lag_s)

    def _change_rig(self, later_s: float) -> None:
        """Go on with the rig as it is known by now, whose wheels were read so much later than was thought."""
        self._optics = optics = Optics.of(self._rig.calibration, self._body, self._optics.view.crop)
        self._colours = None
        self._ego.refit(optics.patch, optics.shutter, self._rig.wheels, later_s)
        if self._last is not None:
            grey, mask = self._last
            bare = optics.patch.bare(mask, FLOOR_MARGIN_IN_HEIGHTS * optics.height_m)
            self._ego.look_back(optics.patch.texture(optics.patch.sample(grey)), bare)
        self._landmarks = Landmarks(optics.patch)  # with the wrong rig, floor lies elsewhere
        self._corners.refit(optics.view, optics.projection)
        self._memory = FloorMemory(optics.patch, optics.view.body_range_m, self._body.body_radius_m, optics.eye_m)
        self._watch.refit(optics.fitter, optics.eye_m)

    def _blind_step(self, frame: Frame, wheels: WheelState) -> Step:
        """Take one step without a picture: the wheels alone, and nothing seen."""
        motion = self._ego.advance_blind(wheels)
        self._landmarks.move(motion)
        self._corners.forget()
        vectors, kept = no_vectors()
        reported = local_map(frame, motion, None, self._optics.view.body_range_m, self._optics.height_m)
        return Step(reported, motion_summary(frame, vectors, kept))

    def _judge(self, grey: Picture, mask: Mask) -> Callable[[RobotFit], float]:
        """Return what tells how much speaks for a robot where one was fitted, given the grey picture and the mask of its view."""
        optics = self._optics
        return lambda fit: robot_evidence(fit, grey, mask, self._body, optics.view, optics.projection)

    def _parted(self, mask: Mask, robots_m: Array) -> Mask:
        """Return the mask of what is not floor with a gap between things, and around the robots expected at (n, 2) [body]."""
        alone = parted_from_robots(mask, robots_m, self._body.body_radius_m, self._optics.view, self._optics.projection)
        return cut_at_depth_steps(open_rings(alone, self._optics.view), self._optics.view, DEPTH_STEP_IN_HEIGHTS * self._optics.height_m)

    def _reduce(self, picture: Picture) -> tuple[Picture, Picture, Picture]:
        """Return the picture in grey, reduced, and reduced in grey."""
        reduced = self._optics.view.reduce(picture)
        grey, small = (cv2.cvtColor(colour, cv2.COLOR_BGR2GRAY) for colour in (picture, reduced))
        return np.asarray(grey, np.uint8), reduced, np.asarray(small, np.uint8)
