"""What is too slight to be anything upright is the floor's own grain."""

from __future__ import annotations

import numpy as np
import pytest

from agent.slam.floor_marks import is_mark
from agent.vision.hull import convex_hull
from protocol.geometry import Array
from tests.unit.agent.floor_worlds import HEIGHT_M, appearances, box, upright

SPECK = box(0.40, 0.44, 0.02)
ACROSS = box(0.40, 0.42, 0.1)  # a joint between two boards, 20 cm of it


def turned(footprint: Array, angle_rad: float) -> Array:
    """Return a footprint turned about its own centre."""
    centre = footprint.mean(axis=0)
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    return np.asarray((footprint - centre) @ np.array([[c, s], [-s, c]]) + centre)


def looks_like_a_mark(footprint: Array, height_m: float) -> bool:
    return is_mark(convex_hull(appearances(upright(footprint, height_m))), HEIGHT_M)


@pytest.mark.parametrize("footprint", [SPECK, ACROSS, turned(box(0.34, 0.44, 0.01), 0.6), turned(box(0.34, 0.44, 0.01), -1.0)])
def test_a_speck_and_a_streak_of_any_direction_are_marks(footprint: Array) -> None:
    assert looks_like_a_mark(footprint, 0.0)


@pytest.mark.parametrize("footprint", [SPECK, ACROSS, turned(ACROSS, 0.6)])
def test_nothing_tall_is_a_mark(footprint: Array) -> None:
    assert not looks_like_a_mark(footprint, 0.6 * HEIGHT_M)


@pytest.mark.parametrize("footprint", [box(0.40, 0.44, 0.1), box(0.9, 1.0, 0.024)])
def test_nothing_wide_or_far_is_a_mark(footprint: Array) -> None:
    assert not looks_like_a_mark(footprint, 0.0)
