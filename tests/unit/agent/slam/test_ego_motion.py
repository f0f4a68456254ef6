"""The robot's own pose over a drive on a rendered floor."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

from agent.slam.ego_motion import EgoMotion, Motion
from agent.slam.odometry import WheelGeometry, WheelNoise, arc_motion, motion_covariance
from agent.vision.floor_patch import Field
from protocol.geometry import Array, Pose2
from tests.synthetic import Box, Shadow, render
from tests.unit.agent.eyes import PATCH, SHUTTER, patch_of, turned

WHEELS = WheelGeometry(radius_m=0.03, base_m=0.12)
THINGS = (Box(0.6, 0.5, 0.4, 0.25, 0.18, 0.2, (40.0, 60.0, 190.0)),)
FRAMES = 15
STEP: Array = np.array([0.9, 1.3])  # [rad: left, right] turned between frames: 3.3 cm and 0.1 rad
WHEEL_ERROR: Array = np.array([1.02, 0.985])  # wheels read so much more than they went


def truth(frame: int) -> Pose2:
    return Pose2.exp(frame * arc_motion(STEP, WHEELS).log())


@cache
def seen(frame: int) -> tuple[Field, NDArray[np.bool_]]:
    return patch_of(render("paint", truth(frame), THINGS, (Shadow(0.3, 0.5, 0.25),), seed=frame))


def drive(blind: frozenset[int] = frozenset()) -> list[Motion]:
    ego = EgoMotion(PATCH, SHUTTER, WHEELS, WheelNoise())
    motions = []
    for frame in range(FRAMES):
        angles = turned(frame * STEP * WHEEL_ERROR)
        motions.append(ego.advance_blind(angles) if frame in blind else ego.advance(angles, *seen(frame)))
    return motions


def error_m(motion: Motion, frame: int) -> float:
    error = truth(frame).between(motion.odom_from_body)
    return float(np.hypot(error.x_m, error.y_m))


def test_a_drive_over_several_keyframes_stays_within_two_millimetres() -> None:
    motions = drive()
    assert all(motion.from_floor for motion in motions[1:])
    assert max(error_m(motion, frame) for frame, motion in enumerate(motions)) < 0.002
    assert abs(truth(FRAMES - 1).between(motions[-1].odom_from_body).theta_rad) < 0.004


def test_steps_chain_to_the_pose() -> None:
    pose = Pose2.identity()
    for motion in drive():
        pose = pose @ motion.previous_from_body
        assert pose == pytest.approx(motion.odom_from_body, abs=1e-9)


def test_a_blind_step_follows_the_wheels() -> None:
    ego = EgoMotion(PATCH, SHUTTER, WHEELS, WheelNoise())
    ego.advance_blind(turned([5.0, 7.0]))
    motion = ego.advance_blind(turned(np.array([5.0, 7.0]) + STEP))
    assert motion.previous_from_body == pytest.approx(arc_motion(STEP, WHEELS), abs=1e-12)
    assert motion.covariance == pytest.approx(motion_covariance(STEP, WHEELS, WheelNoise()))
    assert not motion.from_floor


def test_the_first_step_goes_nowhere_whatever_the_encoders_read() -> None:
    motion = EgoMotion(PATCH, SHUTTER, WHEELS, WheelNoise()).advance(turned([123.0, -45.0]), *seen(0))
    assert motion.odom_from_body == Pose2.identity()
    assert not motion.from_floor


def test_the_floor_makes_good_what_the_wheels_lost_while_blind() -> None:
    motions = drive(blind=frozenset({2, 3}))
    assert [motion.from_floor for motion in motions[:5]] == [False, True, False, False, True]
    assert error_m(motions[3], 3) > 0.0005
    assert error_m(motions[-1], FRAMES - 1) < 0.002


def test_the_same_inputs_give_the_same_poses() -> None:
    first, second = drive(), drive()
    assert [motion.odom_from_body for motion in first] == [motion.odom_from_body for motion in second]
    assert all(np.array_equal(a.covariance, b.covariance) for a, b in zip(first, second, strict=True))
