"""Pictures that come twice."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from agent.vision.repeats import Repeats


def grain(seed: int) -> NDArray[np.uint8]:
    return np.random.default_rng(seed).integers(0, 255, (48, 64, 3), np.uint8)


def test_picture_is_told_from_the_one_before_by_its_noise() -> None:
    repeats = Repeats()
    assert [repeats.look(grain(seed)) for seed in (1, 2, 2, 3, 2)] == [False, False, True, False, False]
    assert repeats.complaint == ""


def test_camera_that_often_repeats_itself_is_told() -> None:
    repeats = Repeats()
    for number in range(60):
        repeats.look(grain(number // 2))
    assert repeats.complaint.startswith("camera: 25 of the last 50 pictures were the same as the one before: ")


def test_camera_that_shows_one_picture_for_ever_is_not_told_to_go_slower() -> None:
    repeats = Repeats()
    for _ in range(40):
        repeats.look(grain(1))
    assert repeats.complaint == "camera: 39 of the last 40 pictures were the same as the one before: pull its plug and put it in again"
