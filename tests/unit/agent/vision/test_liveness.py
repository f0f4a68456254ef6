"""Pictures that show nothing of the world any more."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from agent.vision.liveness import DARK, FROZEN, Liveness

SHAPE = (48, 64, 3)


def grain(seed: int, level: float = 120.0) -> NDArray[np.uint8]:
    return np.random.default_rng(seed).normal(level, 3.0, SHAPE).clip(0, 255).astype(np.uint8)


def turned(angle_rad: float) -> NDArray[np.float64]:
    return np.array([angle_rad, -angle_rad])


@pytest.fixture
def liveness() -> Liveness:
    return Liveness()


def test_pictures_that_differ_are_alive(liveness: Liveness) -> None:
    assert [liveness.fault(grain(seed), turned(0.2 * seed)) for seed in range(5)] == [""] * 5


def test_a_repeated_picture_is_no_fault_while_the_wheels_stand(liveness: Liveness) -> None:
    assert [liveness.fault(grain(1), turned(0.5)) for _ in range(100)] == [""] * 100


def test_a_repeated_picture_is_a_fault_once_the_wheels_have_turned(liveness: Liveness) -> None:
    faults = [liveness.fault(grain(1), turned(angle)) for angle in (0.0, 0.05, 0.11, 0.2)]
    assert faults == ["", "", FROZEN, FROZEN]


def test_a_frozen_camera_stays_so_after_the_wheels_have_stopped_and_until_the_picture_changes(liveness: Liveness) -> None:
    for angle in (0.0, 0.2, 0.2, 0.2):
        fault = liveness.fault(grain(1), turned(angle))
    assert fault == FROZEN
    assert liveness.fault(grain(2), turned(0.2)) == ""


@pytest.mark.parametrize("level", [0.0, 4.0])
def test_a_dark_picture_is_a_fault(liveness: Liveness, level: float) -> None:
    assert liveness.fault(grain(1, level), turned(0.0)) == DARK


def test_a_dim_picture_is_none(liveness: Liveness) -> None:
    assert liveness.fault(grain(1, 25.0), turned(0.0)) == ""
