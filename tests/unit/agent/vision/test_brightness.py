"""Pictures that are too dark to work with, and yet not black."""

from __future__ import annotations

import numpy as np
import pytest

from agent.vision.brightness import LOOKS, TOO_DARK, Brightness


@pytest.mark.parametrize(("level", "complaint"), [(30, TOO_DARK), (80, "")])
def test_dark_pictures_are_told_and_dim_ones_not(level: int, complaint: str) -> None:
    brightness = Brightness()
    for _ in range(LOOKS):
        brightness.look(np.full((48, 64, 3), level, np.uint8))
    assert brightness.complaint == complaint


def test_a_few_dark_pictures_are_a_shadow() -> None:
    brightness = Brightness()
    for level in (100, *[30] * (LOOKS - 1)):
        brightness.look(np.full((48, 64, 3), level, np.uint8))
    assert brightness.complaint == ""
