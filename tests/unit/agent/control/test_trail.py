"""The way that a robot came."""

from __future__ import annotations

import math

import pytest

from agent.control.trail import AHEAD_M, LONGEST, SPACING_M, Trail
from protocol.geometry import Pose2

STEP_M = 0.025  # a tenth of a second at full speed


def driven(*xs_m: float) -> Trail:
    trail = Trail()
    for x_m in xs_m:
        trail.note(Pose2(x_m, 0.0, 0.0))
    return trail


def test_the_way_back_leads_over_the_last_places() -> None:
    trail = driven(*(STEP_M * step for step in range(9)))
    here = Pose2(8 * STEP_M, 0.0, 0.0)
    assert here.x_m - trail.back(here).x_m == pytest.approx(AHEAD_M, abs=STEP_M)


def test_the_way_back_ends_where_it_began() -> None:
    assert driven(0.0).back(Pose2(0.03, 0.0, 0.0)) == Pose2(0.0, 0.0, 0.0)
    assert Trail().back(Pose2(0.03, 0.0, 0.0)) == Pose2(0.03, 0.0, 0.0)


def test_whoever_is_driven_back_goes_on_back() -> None:
    trail, x_m = driven(*(STEP_M * step for step in range(9))), 8 * STEP_M
    for _ in range(30):
        back = trail.back(Pose2(x_m, 0.0, 0.0))
        assert back.x_m <= x_m
        x_m -= min(0.008, x_m - back.x_m)  # of a tenth of a second
        trail.note(Pose2(x_m, 0.0, 0.0))
    assert x_m == pytest.approx(0.0, abs=SPACING_M)


def test_a_detour_that_led_back_is_left_out() -> None:
    trail = driven(0.0, 0.03, 0.06)
    for x_m, y_m in ((0.06, 0.03), (0.06, 0.06), (0.09, 0.06), (0.09, 0.03), (0.065, 0.005)):
        trail.note(Pose2(x_m, y_m, 0.0))
    assert trail.back(Pose2(0.06, 0.0, 0.0)) == Pose2(0.0, 0.0, 0.0)


def test_of_a_long_way_the_end_is_remembered() -> None:
    trail = driven(*(STEP_M * step for step in range(2 * LONGEST)))
    assert trail.back(Pose2(0.0, 0.0, math.pi)).x_m >= STEP_M * LONGEST
