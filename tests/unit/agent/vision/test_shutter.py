"""What a rolling shutter moves, and by how much."""

from __future__ import annotations

import numpy as np
import pytest

from agent.vision.shutter import RollingShutter
from tests.synthetic import HEIGHT_PX
from tests.unit.agent.eyes import PATCH, PROJECTION, SHUTTER

ROLLING = RollingShutter(PATCH, PROJECTION, HEIGHT_PX, readout_s=0.02)
AHEAD_M, ASIDE_M, BEHIND_M = np.array([[0.5, 0.0]]), np.array([[0.0, 0.5]]), np.array([[-0.5, 0.0]])


def test_what_is_ahead_was_seen_earlier_and_has_come_nearer_since() -> None:
    ahead, behind = (ROLLING.displacement_m(points_m, 0.3, 0.0)[0] for points_m in (AHEAD_M, BEHIND_M))
    assert ahead == pytest.approx([-0.3 * 0.02 * 0.5 * np.ptp(rows()) / HEIGHT_PX, 0.0], rel=0.05)
    assert behind == pytest.approx(-ahead, abs=1e-4)


def rows() -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Return the rows in which a point ahead and one behind are seen."""
    return PROJECTION.pixels_from_floor(np.vstack([AHEAD_M, BEHIND_M]))[:, 1]


def test_what_is_beside_the_robot_is_seen_at_the_stamp() -> None:
    assert ROLLING.displacement_m(ASIDE_M, 0.3, 1.0)[0] == pytest.approx([0.0, 0.0], abs=1e-4)


def test_a_turn_moves_what_is_ahead_sideways() -> None:
    moved = ROLLING.displacement_m(AHEAD_M, 0.0, 2.0)[0]
    assert moved[0] == pytest.approx(0.0, abs=1e-9)
    assert moved[1] < -0.001


def test_a_shutter_that_opens_everywhere_at_once_moves_nothing() -> None:
    assert (SHUTTER.displacement_m(AHEAD_M, 0.3, 2.0) == 0.0).all()
