"""A robot that is lifted knows it by the floor, whether or not its wheels turn in the air; what only looks like it is told apart."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

from agent.slam.ego_motion import EgoMotion, Motion
from agent.slam.lifting import SETTLED_PICTURES, TRUSTED_PICTURES
from agent.slam.odometry import WheelGeometry, WheelNoise, arc_motion
from agent.vision.floor_patch import Field
from protocol.geometry import Array, Pose2
from tests.synthetic import render
from tests.unit.agent.eyes import PATCH, SHUTTER, patch_of, turned

WHEELS = WheelGeometry(radius_m=0.03, base_m=0.12)
STEP: Array = np.array([0.6, 0.5])  # [rad: left, right] turned between pictures
ELSEWHERE = Pose2(0.7, -0.4, 1.9)
ASIDE = Pose2(0.0, 0.1, 0.0)  # from where most of the same floor is seen
IN_HANDS = 4  # pictures


class Sight(NamedTuple):
    """One picture, and how far the wheels have turned since the last one."""

    floor: str
    pose: Pose2
    turned_rad: Array


@cache
def patch(floor: str, pose: Pose2, noise: int) -> tuple[Field, NDArray[np.bool_]]:
    return patch_of(render(floor, pose, seed=noise))


def seen(sights: list[Sight]) -> list[Motion]:
    ego, angles = EgoMotion(PATCH, SHUTTER, WHEELS, WheelNoise()), np.zeros(2)
    motions = []
    for number, sight in enumerate(sights):
        angles = angles + sight.turned_rad
        motions.append(ego.advance(turned(angles), *patch(sight.floor, sight.pose, number % 3)))
    return motions


def driving(start: Pose2, pictures: int) -> Iterator[Sight]:
    step = arc_motion(STEP, WHEELS)
    for number in range(pictures):
        yield Sight("paint", start @ Pose2.exp(number * step.log()), STEP if number else np.zeros(2))


def standing(pose: Pose2, pictures: int, floor: str = "paint") -> Iterator[Sight]:
    yield from (Sight(floor, pose, np.zeros(2)) for _ in range(pictures))


def in_hands(turned_rad: Array) -> Iterator[Sight]:
    for number in range(IN_HANDS):
        yield Sight("wood", Pose2(0.3 * number, 0.2, 0.9 * number), turned_rad)


BEFORE = list(driving(Pose2.identity(), TRUSTED_PICTURES + 2))
HERE = BEFORE[-1].pose


@pytest.mark.parametrize("turned_rad", [np.zeros(2), STEP])
@pytest.mark.parametrize("put_down", [ELSEWHERE, HERE @ ASIDE])
def test_a_robot_that_is_put_down_elsewhere_notices(turned_rad: Array, put_down: Pose2) -> None:
    motions = seen([*BEFORE, *in_hands(turned_rad), *standing(put_down, SETTLED_PICTURES + 2)])
    first = len(BEFORE)
    assert not any(motion.in_doubt for motion in motions[:first])
    assert all(motion.in_doubt and motion.lifts == 0 for motion in motions[first : first + IN_HANDS])
    assert motions[-1].lifts == 1
    assert not motions[-1].in_doubt


def test_a_robot_that_is_carried_between_two_pictures_notices() -> None:
    assert seen([*BEFORE, *standing(ELSEWHERE, SETTLED_PICTURES + 2)])[-1].lifts == 1


@pytest.mark.parametrize("covered", [1, IN_HANDS])
def test_a_lens_that_was_covered_shows_the_old_floor_again(covered: int) -> None:
    motions = seen([*BEFORE, *list(in_hands(np.zeros(2)))[:covered], *standing(HERE, SETTLED_PICTURES + 2)])
    assert any(motion.in_doubt for motion in motions)
    assert motions[-1].lifts == 0
    assert not motions[-1].in_doubt


def test_who_drives_without_seeing_the_same_floor_again_cannot_tell() -> None:
    blind = [Sight("wood", Pose2(0.5 * number, 0.0, number), np.array([2.0, 2.0])) for number in range(6)]
    motions = seen([*BEFORE, *blind, *driving(ELSEWHERE, SETTLED_PICTURES + 2)])
    assert motions[-1].lifts == 0
    assert not motions[-1].in_doubt


def test_a_drive_over_floor_that_agrees_is_never_in_doubt() -> None:
    assert not any(motion.in_doubt or motion.lifts for motion in seen(list(driving(Pose2.identity(), 30))))
