"""The nearest thing in every direction, and where robots may stand in it."""

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from agent.vision.outlines import Borders, find_borders
from agent.vision.range_profile import DIRECTIONS, range_profile, round_bases, tall_bases
from protocol.geometry import Array
from tests.unit.agent.floor_worlds import PROJECTION, VIEW, box, disc, seen, upright

RADIUS_M, ROBOT_M, TOLERANCE_M = 0.1, 0.12, 0.01
BEARING_RAD = 0.6
ROBOT = upright(disc(0.9 * math.cos(BEARING_RAD), 0.9 * math.sin(BEARING_RAD), RADIUS_M), ROBOT_M)
SPOT = upright(disc(0.9 * math.cos(BEARING_RAD), 0.9 * math.sin(BEARING_RAD), RADIUS_M), 0.0)
WALL = upright([(0.5, -1.5), (0.9, -1.5), (0.9, 1.5), (0.5, 1.5)], 0.3)


def borders_of(mask: NDArray[np.uint8]) -> Borders:
    return find_borders(mask, VIEW.nadir_px, 25.0)


def profile_of(mask: NDArray[np.uint8]) -> Array:
    return range_profile(borders_of(mask), VIEW, PROJECTION.body_from_camera[:2, 3])


def direction(bearing_rad: float) -> int:
    return int((bearing_rad + math.pi) / (2.0 * math.pi) * DIRECTIONS)


def test_the_profile_is_the_range_to_the_near_side() -> None:
    profile = profile_of(seen(upright(box(0.8, 0.9, 0.2), 0.1)))
    assert profile[direction(0.0)] == pytest.approx(0.8, abs=0.012)
    assert profile[direction(0.2)] == pytest.approx(0.8 / math.cos(0.2), abs=0.02)


def test_there_is_nothing_where_the_floor_is_bare() -> None:
    profile = profile_of(seen(upright(box(0.8, 0.9, 0.2), 0.1)))
    assert np.isinf(profile[direction(0.4) :]).all()
    assert np.isinf(profile[: direction(-0.4)]).all()
    assert np.isinf(profile_of(np.zeros(VIEW.valid.shape, np.uint8))).all()


@pytest.mark.parametrize("bearing_rad", [BEARING_RAD, -2.0, math.pi])
def test_a_disc_at_known_range_gives_its_base_first(bearing_rad: float) -> None:
    robot = upright(disc(0.9 * math.cos(bearing_rad), 0.9 * math.sin(bearing_rad), RADIUS_M), ROBOT_M)
    range_m, bearing = round_bases(profile_of(seen(robot)), RADIUS_M, TOLERANCE_M)[0]
    assert range_m == pytest.approx(0.9, abs=0.015)
    assert math.remainder(bearing - bearing_rad, 2.0 * math.pi) == pytest.approx(0.0, abs=0.02)


def test_every_robot_gives_one_base() -> None:
    others = [upright(disc(x, y, RADIUS_M), ROBOT_M) for x, y in ((-0.8, 0.0), (0.1, -0.7))]
    bases = round_bases(profile_of(seen(ROBOT) | seen(others[0]) | seen(others[1])), RADIUS_M, TOLERANCE_M)
    assert np.sort(bases[:, 0]) == pytest.approx([math.hypot(0.1, 0.7), 0.8, 0.9], abs=0.015)


def test_a_flat_wall_is_no_base_to_the_tolerance_that_a_disc_at_its_place_meets() -> None:
    tolerance_m = 0.003  # a base of 0.1 m bends by 0.0095 m half way to its sides, which counts as 0.007 m so far out
    post = upright(disc(0.5 + RADIUS_M, 0.0, RADIUS_M), ROBOT_M)
    assert len(round_bases(profile_of(seen(WALL)), RADIUS_M, tolerance_m)) == 0
    assert len(round_bases(profile_of(seen(post)), RADIUS_M, tolerance_m)) == 1


def test_a_disc_of_another_size_is_no_base() -> None:
    post = upright(disc(0.9, 0.0, 0.4 * RADIUS_M), ROBOT_M)
    assert len(round_bases(profile_of(seen(post)), RADIUS_M, TOLERANCE_M)) == 0


def test_nothing_seen_gives_no_base() -> None:
    assert len(round_bases(np.full(DIRECTIONS, np.inf), RADIUS_M, TOLERANCE_M)) == 0


def test_a_base_above_which_nothing_rises_is_dropped() -> None:
    base = np.array([[0.9, BEARING_RAD]])
    assert tall_bases(base, ROBOT_M, borders_of(seen(ROBOT)), VIEW, PROJECTION) == pytest.approx(base)
    assert len(tall_bases(base, ROBOT_M, borders_of(seen(SPOT)), VIEW, PROJECTION)) == 0


def test_a_spot_is_round_but_not_tall() -> None:
    mask = seen(SPOT)
    bases = round_bases(profile_of(mask), RADIUS_M, TOLERANCE_M)
    assert len(bases) == 1
    assert len(tall_bases(bases, ROBOT_M, borders_of(mask), VIEW, PROJECTION)) == 0


def test_only_the_tall_ones_of_several_are_kept() -> None:
    bases = np.array([[0.9, BEARING_RAD + 1.5], [0.9, BEARING_RAD]])
    assert tall_bases(bases, ROBOT_M, borders_of(seen(ROBOT)), VIEW, PROJECTION) == pytest.approx(bases[1:])
    assert tall_bases(bases[:0], ROBOT_M, borders_of(seen(ROBOT)), VIEW, PROJECTION).shape == (0, 2)
