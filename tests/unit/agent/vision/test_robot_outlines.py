"""Other robots are cut out of the mask, so that what they touch keeps its own outline."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from agent.vision.robot_outlines import GAP_M, parted_from_robots
from protocol.geometry import Array
from tests.unit.agent.floor_worlds import PROJECTION, VIEW, box, disc, seen, upright

RADIUS_M = 0.075
ROBOT = np.array([0.6, 0.0])
BODY = upright(disc(ROBOT[0], ROBOT[1], RADIUS_M), 0.3)
BESIDE = upright(box(0.7, 0.9, 0.06) + np.array([0.0, 0.14]), 0.15)  # in the picture it touches the robot's side


def parted(mask: NDArray[np.uint8], *robots_m: Array) -> NDArray[np.uint8]:
    return parted_from_robots(mask, np.array(robots_m).reshape(-1, 2), RADIUS_M, VIEW, PROJECTION)


def parts(mask: NDArray[np.uint8]) -> list[NDArray[np.bool_]]:
    """Return the parts of a mask, the largest first, without specks."""
    count, numbers = cv2.connectedComponents(mask, connectivity=8)
    found = [numbers == number for number in range(1, count)]
    return sorted((part for part in found if part.sum() > 25), key=lambda part: -int(part.sum()))


def test_a_thing_that_touches_a_robot_becomes_a_region_of_its_own() -> None:
    both = seen(BODY) | seen(BESIDE)
    assert len(parts(both)) == 1
    robot, thing = parts(parted(both, ROBOT))
    assert (robot & (seen(BODY) > 0)).sum() > 0.95 * robot.sum()
    assert (thing & (seen(BESIDE) > 0)).sum() > 0.95 * thing.sum()


def test_no_floor_between_them_is_left_in_the_mask() -> None:
    gap = (VIEW.range_m < 0.6 - RADIUS_M - 0.005) & (VIEW.range_m > 0.6 - RADIUS_M - GAP_M + 0.005) & (np.abs(VIEW.bearing_rad) < 0.02)
    mask = np.asarray(seen(BODY) | gap, np.uint8)
    assert gap.any()
    assert not (parted(mask, ROBOT)[gap] > 0).any()


@pytest.mark.parametrize("robots_m", [[], [np.array([50.0, 0.0])], [np.array([0.02, 0.0])]])
def test_without_a_robot_in_sight_the_mask_stays_as_it_is(robots_m: list[Array]) -> None:
    both = seen(BODY) | seen(BESIDE)
    assert np.array_equal(parted(both, *robots_m), both)


def test_what_stands_well_away_from_robots_stays_whole() -> None:
    aside = seen(upright(box(0.5, 0.6, 0.1) + np.array([0.0, 0.5]), 0.15))
    assert np.array_equal(parted(aside | seen(BODY), ROBOT) & aside, aside)
