"""Motion from the floor where that is hard: too much light or none, little floor in view, parts that move, a turn on the spot."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from itertools import pairwise

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from agent.slam.ego_motion import KEYFRAME_TURN_RAD, EgoMotion, Motion
from agent.slam.floor_motion import Alignment, Glance, align, make_keyframe
from agent.slam.odometry import WheelGeometry, WheelNoise
from agent.vision.floor_patch import Field
from protocol.geometry import Array, Pose2
from tests.synthetic import Box, render
from tests.unit.agent.eyes import PATCH, SHUTTER, VIEW, patch_of, turned

START = Pose2(0.3, -0.2, 0.25)
MOTION = Pose2(0.03, 0.01, 0.12)
PREDICTED = MOTION @ Pose2(0.006, -0.003, 0.02)
PREDICTION: Array = np.diag([0.01**2, 0.005**2, 0.03**2])
WHEELS = WheelGeometry(radius_m=0.03, base_m=0.12)
TILES = tuple(
    Box(START.x_m + 0.4 * np.cos(turn), START.y_m + 0.4 * np.sin(turn), turn, 0.03, 0.03, 0.002, (20.0, 20.0, 20.0))
    for turn in np.arange(0.0, 6.0, 0.5)
)


@cache
def ring() -> NDArray[np.bool_]:
    """Return all cells between the own body and the patch's reach."""
    cv2.setNumThreads(1)
    return PATCH.bare(np.zeros(VIEW.valid.shape, np.uint8), margin_m=0.0)


@cache
def cells_at(pose: Pose2, seed: int, exposure: float = 1.0, tiled: bool = False, floor: str = "concrete") -> Field:
    return patch_of(render(floor, pose, TILES if tiled else (), seed=seed, exposure=exposure))[0]


def aligned(cells: Field, tiled: bool = False, seen: NDArray[np.bool_] | None = None) -> Alignment | None:
    where = ring() if seen is None else seen
    keyframe = make_keyframe(PATCH, Glance(cells_at(START, 0, tiled=tiled), where, SHUTTER))
    assert keyframe is not None
    return align(keyframe, Glance(cells, where, SHUTTER), PREDICTED, PREDICTION)


def errors(found: Alignment | None, motion: Pose2 = MOTION) -> Array:
    """Return by how much the motion was missed, (3,) [m, m, rad]."""
    assert found is not None
    return np.abs(motion.between(found.keyframe_from_body).log())


@pytest.mark.parametrize("exposure", [0.6, 1.4])
def test_a_jump_of_exposure_is_no_motion(exposure: float) -> None:
    assert errors(aligned(cells_at(START @ MOTION, 1, exposure))).max() < 1e-3


@pytest.mark.parametrize("exposure", [1.8, 2.0, 2.5, 3.0])
def test_an_overexposed_picture_is_aligned_by_what_is_left_of_it(exposure: float) -> None:
    cells = cells_at(START @ MOTION, 1, exposure, tiled=True)
    assert np.isfinite(cells).all()
    assert errors(aligned(cells, tiled=True)).max() < 1e-3


def test_a_dark_picture_tells_no_motion() -> None:
    assert aligned(cells_at(START @ MOTION, 1, exposure=0.0)) is None


def test_a_quarter_of_the_floor_is_enough() -> None:
    quarter = ring() & (PATCH.points_m > 0.0).all(axis=-1)
    assert errors(aligned(cells_at(START @ MOTION, 1), seen=quarter)).max() < 2e-3


def test_a_third_of_the_floor_that_moves_by_itself_does_not_pull() -> None:
    elsewhere = cells_at(START @ MOTION @ Pose2(0.006, 0.006, 0.02), 2)
    cells = np.where(PATCH.points_m[..., 0] > 0.25, elsewhere, cells_at(START @ MOTION, 1))
    assert errors(aligned(cells)).max() < 1e-3


def test_less_floor_in_view_is_believed_less() -> None:
    cells = cells_at(START @ MOTION, 1)
    everything, part = aligned(cells), aligned(cells, seen=ring() & (PATCH.points_m[..., 0] > 0.35))
    assert everything is not None
    assert part is not None
    assert (np.diag(part.covariance) > np.diag(everything.covariance)).all()


def drive(way: Sequence[Pose2], dark: int = -1, slip_rad: float = 0.0) -> list[Motion]:
    """Return the steps of a drive along `way` [body at the start]; one picture may be dark, and the right wheel spin in the last step."""
    ego, angles, motions = EgoMotion(PATCH, SHUTTER, WHEELS, WheelNoise()), np.zeros(2), []
    for index, (before, now) in enumerate(pairwise([way[0], *way])):
        ahead_m, _, turn_rad = before.between(now).log()
        aside_m = 0.5 * WHEELS.base_m * turn_rad
        spin_m = slip_rad * WHEELS.base_m if index == len(way) - 1 else 0.0
        angles = angles + (np.array([ahead_m - aside_m, ahead_m + aside_m]) * 1.02 + (0.0, spin_m)) / WHEELS.radius_m
        cells = cells_at(START @ now, seed=index % 6, exposure=0.0 if index == dark else 1.0)
        motions.append(ego.advance(turned(angles), cells, ring()))
    return motions


def missed(motion: Motion, true: Pose2) -> Array:
    return np.abs(true.between(motion.odom_from_body).log())


def test_a_turn_on_the_spot_is_followed_past_a_keyframe() -> None:
    way = [Pose2(0.0, 0.0, 0.15 * step) for step in range(7)]
    assert way[-1].theta_rad > 1.5 * KEYFRAME_TURN_RAD
    motions = drive(way)
    assert all(motion.from_floor for motion in motions[1:])
    assert max(missed(motion, true).max() for motion, true in zip(motions, way, strict=True)) < 2e-3


def test_while_near_its_keyframe_the_robot_does_not_drift() -> None:
    to_and_fro = [Pose2(0.06 * (step % 2), 0.0, 0.0) for step in range(25)]
    assert missed(drive(to_and_fro)[-1], to_and_fro[-1])[:2].max() < 1e-4


def test_a_dark_picture_costs_two_steps_by_wheels_at_most() -> None:
    way = [Pose2.exp((0.045 * step, 0.0, 0.03 * step)) for step in range(7)]
    motions = drive(way, dark=3)
    assert not motions[3].from_floor
    assert [motion.from_floor for motion in motions[1:3] + motions[5:]] == [True] * 4
    assert missed(motions[-1], way[-1])[:2].max() < 3e-3


def test_a_wheel_that_spins_is_found_out() -> None:
    way = [Pose2.identity(), Pose2(0.045, 0.0, 0.0)]
    slipped = drive(way, slip_rad=0.15)[-1]
    assert slipped.from_floor
    assert missed(slipped, way[-1]).max() < 1.5e-3


def test_the_doubt_about_a_step_covers_what_was_missed() -> None:
    way = [Pose2.exp((0.045 * step, 0.0, 0.03 * step)) for step in range(7)]
    for motion, (before, now) in zip(drive(way)[1:], pairwise(way), strict=True):
        error = before.between(now).between(motion.previous_from_body).log()
        assert np.abs(error / np.sqrt(np.diag(motion.covariance))).max() < 3.5
