"""An old keyframe's floor is found again where it is the same and tells one place, and nowhere else."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from agent.slam.floor_motion import Glance, Keyframe, make_keyframe
from agent.slam.recognition import recognise
from protocol.geometry import Array, Pose2
from tests.synthetic import render
from tests.synthetic_floors import TEXTURED
from tests.unit.agent.eyes import PATCH, SHUTTER, patch_of

PLACE = Pose2(0.31, -0.22, 0.25)
RETURN = Pose2(0.08, -0.05, 2.0)  # comes back another way
MESH_M = 0.05  # of the grid floor
WELL_KNOWN: Array = np.diag([0.002**2, 0.002**2, 0.004**2])
LOST_BY_A_MESH: Array = np.diag([0.011**2, 0.011**2, 0.005**2])


@cache
def glance(floor: str, pose: Pose2, seed: int, exposure: float = 1.0) -> Glance:
    return Glance(*patch_of(render(floor, pose, seed=seed, exposure=exposure)), SHUTTER)


@cache
def keyframe(floor: str) -> Keyframe:
    made = make_keyframe(PATCH, glance(floor, PLACE, seed=0))
    assert made is not None
    return made


@pytest.mark.parametrize("floor", TEXTURED)
def test_a_place_is_recognised_from_another_heading(floor: str) -> None:
    found = recognise(keyframe(floor), glance(floor, PLACE @ RETURN, seed=1), RETURN @ Pose2(0.003, -0.002, 0.005), WELL_KNOWN)
    assert found is not None
    assert np.abs(RETURN.between(found.keyframe_from_body).log()).max() < 5e-4


def test_a_robot_that_may_be_a_mesh_off_is_found_where_the_floor_is_the_same_but_once() -> None:
    predicted = RETURN @ Pose2(0.026, -0.024, 0.004)
    found = recognise(keyframe("concrete"), glance("concrete", PLACE @ RETURN, seed=1), predicted, LOST_BY_A_MESH)
    assert found is not None
    assert np.abs(RETURN.between(found.keyframe_from_body).log()).max() < 5e-4


@pytest.mark.parametrize("off_m", [0.0, 0.3 * MESH_M, 0.5 * MESH_M, 0.7 * MESH_M])
def test_on_a_grid_a_robot_that_may_be_a_mesh_off_recognises_nothing(off_m: float) -> None:
    predicted = RETURN @ Pose2(off_m, off_m, 0.0)
    assert recognise(keyframe("grid"), glance("grid", PLACE @ RETURN, seed=1), predicted, LOST_BY_A_MESH) is None


def test_another_floor_is_not_recognised() -> None:
    elsewhere = glance("concrete", PLACE @ Pose2(0.9, 0.4, 0.3), seed=1)
    assert recognise(keyframe("concrete"), elsewhere, RETURN, WELL_KNOWN) is None
    assert recognise(keyframe("concrete"), elsewhere, RETURN, LOST_BY_A_MESH) is None


def test_in_the_dark_nothing_is_recognised() -> None:
    assert recognise(keyframe("paint"), glance("paint", PLACE @ RETURN, seed=1, exposure=0.0), RETURN, WELL_KNOWN) is None


def test_who_may_be_anywhere_is_not_looked_for() -> None:
    anywhere = np.diag([0.3**2, 0.3**2, 1.0])
    assert recognise(keyframe("paint"), glance("paint", PLACE @ RETURN, seed=1), RETURN, anywhere) is None
