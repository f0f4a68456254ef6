"""The robot's own motion from the floor's texture, on rendered floors."""

from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray

from agent.slam.ego_motion import EgoMotion
from agent.slam.floor_motion import Glance, align, make_keyframe
from agent.slam.odometry import WheelGeometry, WheelNoise
from agent.vision.floor_patch import Field
from protocol.geometry import Pose2
from tests.synthetic import render
from tests.unit.agent.eyes import PATCH, SHUTTER, patch_of, turned

START = Pose2(0.2, -0.1, 0.3)
MOTION = Pose2(0.03, 0.002, 0.05)
WHEELS = np.diag([0.005**2, 0.005**2, 0.02**2])
GEOMETRY = WheelGeometry(radius_m=0.03, base_m=0.12)


def sample(floor: str, pose: Pose2, seed: int) -> Field:
    return patch_of(render(floor, pose, seed=seed))[0]


def everywhere() -> NDArray[np.bool_]:
    range_m = np.hypot(PATCH.points_m[..., 0], PATCH.points_m[..., 1])
    return np.asarray((range_m > 0.25) & (range_m < 0.7))


def glance(cells: Field, bare: NDArray[np.bool_] | None = None) -> Glance:
    return Glance(cells, everywhere() if bare is None else bare, SHUTTER)


@pytest.mark.parametrize("floor", ["paint", "grid", "wood", "concrete"])
@pytest.mark.parametrize("motion", [MOTION, Pose2(0.05, 0.0, 0.0), Pose2(0.0, 0.0, 0.2)])
def test_a_known_motion_is_found_though_the_wheels_are_a_centimetre_wrong(floor: str, motion: Pose2) -> None:
    keyframe = make_keyframe(PATCH, glance(sample(floor, START, 1)))
    assert keyframe is not None
    predicted = motion @ Pose2(0.007, -0.007, 0.01)
    found = align(keyframe, glance(sample(floor, START @ motion, 2)), predicted, 4.0 * WHEELS)
    assert found is not None
    error = motion.between(found.keyframe_from_body)
    assert np.hypot(error.x_m, error.y_m) < 0.0008
    assert abs(error.theta_rad) < 0.0015


def test_a_turn_that_slipping_wheels_hide_is_found() -> None:
    turn = Pose2(0.0, 0.0, 0.15)
    keyframe = make_keyframe(PATCH, glance(sample("concrete", START, 1)))
    assert keyframe is not None
    found = align(keyframe, glance(sample("concrete", START @ turn, 2)), Pose2.identity(), 0.01 * WHEELS)
    assert found is not None
    assert abs(turn.between(found.keyframe_from_body).theta_rad) < 0.003


def test_too_little_bare_floor_makes_no_keyframe() -> None:
    assert make_keyframe(PATCH, glance(sample("paint", START, 1), np.zeros(PATCH.points_m.shape[:2], np.bool_))) is None


def test_another_floor_is_not_taken_for_the_same() -> None:
    keyframe = make_keyframe(PATCH, glance(sample("concrete", START, 1)))
    assert keyframe is not None
    assert align(keyframe, glance(sample("paint", START, 2)), Pose2.identity(), WHEELS) is None


def wheel_angles(path: list[Pose2]) -> list[NDArray[np.float64]]:
    """Return cumulative angles, (2,) each, of wheels that count two per cent too little."""
    angles = [np.zeros(2)]
    for before, after in pairwise(path):
        ahead, _, turn = before.between(after).log()
        half = 0.5 * turn * GEOMETRY.base_m
        angles.append(angles[-1] + np.array([ahead - half, ahead + half]) / GEOMETRY.radius_m / 1.02)
    return angles


def test_a_drive_stays_true_where_the_wheels_do_not_and_a_blind_step_follows_the_wheels() -> None:
    path = [START]
    for _ in range(10):
        path.append(path[-1] @ Pose2.exp((0.03, 0.0, 0.04)))
    angles = wheel_angles(path)
    ego = EgoMotion(PATCH, SHUTTER, GEOMETRY, WheelNoise())
    for index, (pose, reading) in enumerate(zip(path, angles, strict=True)):
        motion = ego.advance(turned(reading), sample("concrete", pose, index), everywhere())
    error = START.between(path[-1]).between(motion.odom_from_body)
    assert motion.from_floor
    assert np.hypot(error.x_m, error.y_m) < 0.002
    assert abs(error.theta_rad) < 0.003
    blind = ego.advance_blind(turned(angles[-1] + 1.0))
    assert not blind.from_floor
    assert blind.previous_from_body == pytest.approx((0.03, 0.0, 0.0), abs=1e-9)
