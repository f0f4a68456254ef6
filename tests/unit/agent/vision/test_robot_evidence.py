"""What speaks for a robot: it is no floor from foot to rim, not part of something larger, and has no pattern across it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from agent.rig import Body
from agent.vision.robot_evidence import LEAST_SHOWN, looks, robot_evidence
from agent.vision.robot_fit import RobotFit
from tests.unit.agent.floor_worlds import PROJECTION, VIEW, box, disc, seen, upright

RADIUS_M, HEIGHT_M = 0.075, 0.3
BODY = Body(RADIUS_M, HEIGHT_M, 0.12, 0.03)
ROBOT = np.array([0.6, 0.0])
MASK = seen(upright(disc(ROBOT[0], ROBOT[1], RADIUS_M), HEIGHT_M))
BESIDE = seen(upright(box(0.7, 0.9, 0.06) + np.array([0.0, 0.14]), 0.15))
SHARP = RobotFit(ROBOT, np.eye(2) * 1e-6, support=0.9, misfit_px=0.2)


EVEN = np.full((960, 1280), 120, np.uint8)
CHEQUERED = np.asarray(np.kron(np.indices((80, 107)).sum(axis=0) % 2, np.ones((12, 12))) * 200 + 20, np.uint8)[:960, :1280]


def evidence(mask: NDArray[np.uint8], fit: RobotFit = SHARP, grey: NDArray[np.uint8] = EVEN) -> float:
    return robot_evidence(fit, grey, mask, BODY, VIEW, PROJECTION)


def cylinder(radius_m: float, height_m: float) -> NDArray[np.uint8]:
    """Return the mask of a cylinder whose near side is where the robot's would be."""
    return seen(upright(disc(ROBOT[0] - RADIUS_M + radius_m, ROBOT[1], radius_m), height_m))


def test_a_robot_can_stand_where_no_floor_shows_through_it() -> None:
    def shown(mask: NDArray[np.uint8]) -> float:
        return float(looks(SHARP, EVEN, mask, BODY, VIEW, PROJECTION)[0])

    assert shown(MASK) == 1.0
    assert shown(np.zeros_like(MASK)) == 0.0
    assert shown(cylinder(RADIUS_M, 0.1)) < LEAST_SHOWN
    assert shown(BESIDE) < 0.3


def test_a_robot_alone_and_one_that_touches_a_thing_are_robots() -> None:
    assert evidence(MASK) > 3.0
    assert evidence(MASK | BESIDE) > 1.0


@pytest.mark.parametrize(("radius_m", "height_m"), [(RADIUS_M, 0.18), (0.15, 0.24), (0.2, HEIGHT_M)])
def test_a_patterned_thing_that_is_lower_or_wider_is_none(radius_m: float, height_m: float) -> None:
    patterned = replace(SHARP, misfit_px=0.8)
    assert evidence(cylinder(radius_m, height_m), patterned, CHEQUERED) < 0.0


def test_edges_beside_its_sides_speak_against_a_robot() -> None:
    assert evidence(MASK, replace(SHARP, misfit_px=1.0)) < evidence(MASK) - 1.0


def test_a_pattern_across_it_speaks_against_a_robot() -> None:
    assert evidence(MASK, grey=CHEQUERED) < evidence(MASK) - 3.0


def test_where_floor_shows_through_nothing_speaks_for_a_robot() -> None:
    assert evidence(BESIDE) == -np.inf
