"""The 25 arenas that every version of the swarm has to master: what all of them hold, by measures of this file's own."""

from __future__ import annotations

import math
from functools import cache
from itertools import combinations

import cv2
import numpy as np
import pytest
import shapely
from numpy.typing import NDArray

from protocol.errors import ConfigError
from sim.arena import SOAK, random_arena
from sim.scenario import Scenario

BODY_M = 0.075
WEDGE_M = 0.40 * math.sin(math.radians(35.0)) + BODY_M
PIXEL_M = 0.01
FLOOR = shapely.box(-2.0, -1.5, 2.0, 1.5)

soak = pytest.mark.parametrize(("seed", "robots"), SOAK)


@cache
def arena(seed: int, robots: int) -> Scenario:
    return random_arena(seed, robots)


def footprints(scenario: Scenario) -> list[shapely.Polygon]:
    """Return the obstacles as shapely makes them."""
    boxes = [
        shapely.affinity.translate(
            shapely.affinity.rotate(
                shapely.box(-b.size_m[0] / 2, -b.size_m[1] / 2, b.size_m[0] / 2, b.size_m[1] / 2), b.yaw_rad, (0, 0), True
            ),
            *b.centre_m,
        )
        for b in scenario.boxes
    ]
    return [*boxes, *(shapely.Point(c.centre_m).buffer(c.radius_m, quad_segs=32) for c in scenario.cylinders)]


def free_floor(scenario: Scenario, radius_m: float) -> NDArray[np.uint8]:
    """Return a picture, 1 cm a pixel, that is 255 where a disc can stand."""
    picture = np.zeros((302, 402), dtype=np.uint8)
    picture[1:-1, 1:-1] = 255
    for footprint in footprints(scenario):
        cv2.fillPoly(picture, [pixel(shapely.get_coordinates(footprint.exterior))], (0,))
    clearance_px = cv2.distanceTransform(picture, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    return np.where(clearance_px * PIXEL_M >= radius_m, 255, 0).astype(np.uint8)


def pixel(points_m: object) -> NDArray[np.int32]:
    return np.asarray(np.rint((np.asarray(points_m) - FLOOR.bounds[:2]) / PIXEL_M + 0.5), dtype=np.int32)


def passes(scenario: Scenario, radius_m: float) -> bool:
    """Tell whether a disc of this radius gets from the leader's start to the goal."""
    picture = free_floor(scenario, radius_m)
    start, goal = pixel(scenario.robots[0].start[:2]), pixel(scenario.goals_m[0])
    if picture[start[1], start[0]] == 0:
        return False
    cv2.floodFill(picture, None, (int(start[0]), int(start[1])), (100,))
    return bool(picture[goal[1], goal[0]] == 100)


def test_there_are_twenty_arenas_for_three_robots_and_five_for_six() -> None:
    assert [robots for _, robots in SOAK] == [3] * 20 + [6] * 5
    assert len(set(SOAK)) == 25


@soak
def test_eight_to_twelve_obstacles_cover_a_twentieth_to_a_fifth_of_the_floor(seed: int, robots: int) -> None:
    obstacles = footprints(arena(seed, robots))
    assert 8 <= len(obstacles) <= 12
    assert all(FLOOR.contains(obstacle) for obstacle in obstacles)
    assert 0.05 <= sum(obstacle.area for obstacle in obstacles) / FLOOR.area <= 0.20


@soak
def test_heights_are_those_of_small_things(seed: int, robots: int) -> None:
    scenario = arena(seed, robots)
    assert all(0.05 <= thing.height_m <= 0.25 for thing in (*scenario.boxes, *scenario.cylinders))


@soak
def test_whatever_looks_like_a_passage_is_one(seed: int, robots: int) -> None:
    obstacles = footprints(arena(seed, robots))
    assert all(one.distance(other) >= 0.30 for one, other in combinations([*obstacles, FLOOR.exterior], 2))


@soak
def test_one_robot_reaches_the_goal_and_the_wedge_has_to_narrow(seed: int, robots: int) -> None:
    scenario = arena(seed, robots)
    assert passes(scenario, BODY_M + 0.06)
    assert not passes(scenario, WEDGE_M)


@soak
def test_the_goal_is_far_and_has_room_for_the_formation(seed: int, robots: int) -> None:
    scenario = arena(seed, robots)
    goal_m = scenario.goals_m[0]
    assert math.dist(scenario.robots[0].start[:2], goal_m) >= 2.5
    assert all(shapely.Point(goal_m).distance(obstacle) >= 0.5 for obstacle in footprints(scenario))


@soak
def test_every_robot_starts_free_and_faces_the_goal(seed: int, robots: int) -> None:
    scenario = arena(seed, robots)
    assert len(scenario.robots) == robots
    obstacles = footprints(scenario)
    goal_x_m, goal_y_m = scenario.goals_m[0]
    leader_x_m, leader_y_m, _ = scenario.robots[0].start
    heading_rad = math.atan2(goal_y_m - leader_y_m, goal_x_m - leader_x_m)
    for robot in scenario.robots:
        place = shapely.Point(robot.start[:2])
        assert min(place.distance(obstacle) for obstacle in obstacles) >= BODY_M + 0.10
        assert place.distance(FLOOR.exterior) >= BODY_M + 0.02
        assert abs(robot.start[2] - heading_rad) < math.radians(6.0)
    assert all(math.dist(one.start[:2], other.start[:2]) >= 0.3 for one, other in combinations(scenario.robots, 2))


def test_the_same_seed_gives_the_same_arena_and_another_seed_another() -> None:
    assert random_arena(7, 3) == random_arena(7, 3)
    assert random_arena(7, 3) != random_arena(8, 3)


@pytest.mark.parametrize("robots", [1, 2, 5, 8, 12])
def test_there_is_an_arena_for_other_swarms_too(robots: int) -> None:
    scenario = random_arena(1, robots)
    assert [robot.name for robot in scenario.robots] == [f"r{number}" for number in range(1, robots + 1)]
    assert passes(scenario, BODY_M + 0.06)


@pytest.mark.parametrize("robots", [0, 13])
def test_a_swarm_that_has_no_room_is_refused(robots: int) -> None:
    with pytest.raises(ConfigError, match=f"room for 1 to 12 robots, not {robots}"):
        random_arena(1, robots)
