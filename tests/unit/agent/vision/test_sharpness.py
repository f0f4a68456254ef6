"""Focus is judged by the hardest edges, not by how much there is to see."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from agent.vision.sharpness import LOOKS, LOST_FOCUS, Focus, sharpness


def edges(smear_px: float = 0.0, noise: float = 2.0, seed: int = 0) -> NDArray[np.uint8]:
    """Return a light ring on dark ground, smeared by the lens before the sensor adds its noise."""
    picture = np.full((170, 170), 60.0)
    cv2.circle(picture, (85, 85), 53, 200.0, 3)
    if smear_px:
        picture = cv2.GaussianBlur(picture, (0, 0), smear_px)
    return (picture + np.random.default_rng(seed).normal(0.0, noise, picture.shape)).clip(0, 255).astype(np.uint8)


def complaint(*pictures: NDArray[np.uint8]) -> str:
    focus = Focus()
    for picture in pictures:
        focus.look(picture)
    return focus.complaint


@pytest.mark.parametrize("noise", [0.0, 2.0, 4.0])
def test_smeared_edges_are_less_sharp_whatever_the_noise(noise: float) -> None:
    found = [sharpness(edges(smear_px, noise)) or 0.0 for smear_px in (0.0, 1.0, 2.0)]
    assert found[0] > 1.2
    assert max(found[1:]) < 0.75


def test_plain_picture_tells_nothing_of_sharpness() -> None:
    plain = np.random.default_rng(1).normal(120.0, 3.0, (170, 170)).astype(np.uint8)
    assert sharpness(plain) is None
    assert complaint(*[plain] * 3 * LOOKS) == ""


def test_lens_that_loses_focus_is_told() -> None:
    assert complaint(*[edges(seed=number) for number in range(LOOKS)], *[edges(2.0, seed=number) for number in range(LOOKS)]) == LOST_FOCUS


def test_lens_that_was_never_in_focus_is_told() -> None:
    assert complaint(*[edges(3.0, noise=1.0, seed=number) for number in range(LOOKS)]) == LOST_FOCUS


def test_one_smeared_picture_is_no_lost_focus() -> None:
    assert complaint(*[edges(seed=number) for number in range(2 * LOOKS)], edges(2.0)) == ""
