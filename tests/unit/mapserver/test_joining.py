"""Robots without a start find their places by seeing each other; what might be otherwise is not decided."""

from __future__ import annotations

import math

import numpy as np
import pytest

from mapserver.pipeline import Merged
from protocol.geometry import Pose2
from tests.unit.mapserver.seekers import Team
from tests.unit.mapserver.worlds import rectangle

SIDE_M = 0.5
AHEAD, ARC = Pose2(0.03, 0.0, 0.0), Pose2(0.03, 0.0, 0.06)
EQUILATERAL = {
    "r1": Pose2(0.0, 0.0, 0.0),
    "r2": Pose2(-SIDE_M * math.cos(math.pi / 6), SIDE_M / 2, 0.0),
    "r3": Pose2(-SIDE_M * math.cos(math.pi / 6), -SIDE_M / 2, 0.0),
}
UNEVEN = {"r1": Pose2(0.0, 0.0, 0.0), "r2": Pose2(-0.4, 0.35, 0.4), "r3": Pose2(-0.7, -0.2, -0.3)}
COLUMN = {f"r{number + 1}": Pose2(-0.45 * number, 0.0, 0.0) for number in range(4)}
NEIGHBOURS = [(f"r{a}", f"r{b}") for a in range(1, 5) for b in range(1, 5) if abs(a - b) == 1]


def placed(merged: Merged) -> list[str]:
    return [each.robot for each in merged.poses.robots]


@pytest.mark.parametrize("seed", range(3))
def test_robots_that_see_each_other_find_their_places(seed: int) -> None:
    team = Team(UNEVEN, seed=seed)
    merged = team.drive(6, ARC)
    assert placed(merged) == ["r1", "r2", "r3"]
    assert merged.poses.seekers == ()
    assert max(team.error_m(merged, robot) for robot in UNEVEN) < 0.005


def test_a_seeker_has_no_pose_and_is_named_as_such() -> None:
    merged = Team(UNEVEN, seen=[]).drive(3, ARC)
    assert placed(merged) == ["r1"]
    assert merged.poses.seekers == ("r2", "r3")


def test_two_that_stand_and_see_each_other_are_not_certain_and_join_once_they_drive() -> None:
    team = Team({robot: UNEVEN[robot] for robot in ("r1", "r2")})
    assert placed(team.drive(30)) == ["r1"]
    assert placed(team.drive(10, ARC)) == ["r1", "r2"]


def test_in_an_even_triangle_that_stands_nobody_knows_who_is_where() -> None:
    assert placed(Team(EQUILATERAL).drive(50)) == ["r1"]


def test_an_even_triangle_that_drives_tells_who_is_where() -> None:
    team = Team(EQUILATERAL)
    merged = team.drive(12, AHEAD)
    assert placed(merged) == ["r1", "r2", "r3"]
    assert max(team.error_m(merged, robot) for robot in EQUILATERAL) < 0.01


def test_in_a_straight_column_nobody_takes_the_place_of_another() -> None:
    """Whoever follows sees the same as whoever follows it, as long as all drive straight on."""
    assert placed(Team(COLUMN, seen=NEIGHBOURS).drive(60, AHEAD)) == ["r1"]


@pytest.mark.parametrize("seed", range(3))
def test_a_column_that_drives_round_a_bend_finds_its_order(seed: int) -> None:
    team = Team(COLUMN, seen=NEIGHBOURS, seed=seed)
    merged = team.drive(30, AHEAD)
    for step in range(60):
        turning = {robot: Pose2(0.03, 0.0, 0.1 if 15 * number <= step < 15 * number + 8 else 0.0) for number, robot in enumerate(COLUMN)}
        merged = team.step(turning)
        for robot in placed(merged):
            assert team.error_m(merged, robot) < 0.02, (step, robot)
    assert len(placed(merged)) > 1


def test_who_is_seen_driving_on_a_bend_is_found_without_seeing_anybody() -> None:
    team = Team({"r1": Pose2.identity(), "r2": Pose2(0.6, -0.3, 1.0)}, seen=[("r1", "r2")])
    merged = team.drive(25, {"r2": ARC})
    assert placed(merged) == ["r1", "r2"]
    assert team.error_m(merged, "r2") < 0.01


def test_who_sees_another_drive_by_is_found_without_being_seen() -> None:
    team = Team({"r1": Pose2.identity(), "r2": Pose2(0.6, -0.3, 1.0)}, seen=[("r2", "r1")])
    merged = team.drive(25, {"r1": ARC})
    assert placed(merged) == ["r1", "r2"]
    assert team.error_m(merged, "r2") < 0.01


def test_two_that_drive_alike_and_see_nobody_are_not_told_apart() -> None:
    team = Team({"r1": Pose2.identity(), "r2": Pose2(0.6, -0.3, 0.0), "r3": Pose2(0.6, 0.3, 0.0)}, seen=[("r1", "r2"), ("r1", "r3")])
    assert placed(team.drive(30, ARC)) == ["r1"]


@pytest.mark.parametrize("seed", range(5))
def test_a_robot_elsewhere_is_not_taken_for_a_stranger_who_stands_just_as_far_off(seed: int) -> None:
    """r1 sees a robot that is none of the team, and so does r2, far away, at the same distance."""
    strangers = [Pose2(0.5, 0.0, 0.0), Pose2(10.5, 0.0, 0.0)]
    team = Team({"r1": Pose2.identity(), "r2": Pose2(10.0, 0.0, 0.0)}, strangers=strangers, seed=seed)
    assert placed(team.drive(20)) == ["r1"]
    assert placed(team.drive(20, {"r1": Pose2(0.0, 0.02, 0.03), "r2": Pose2(0.01, 0.0, 0.02)})) == ["r1"]


def test_where_no_start_is_told_the_first_robots_is_the_origin() -> None:
    merged = Team(UNEVEN).drive(1)
    assert merged.poses.robots[0].arena_from_body == pytest.approx((0.0, 0.0, 0.0), abs=1e-6)


def test_objects_tell_who_is_where_in_an_even_triangle_that_stands() -> None:
    team = Team(EQUILATERAL)
    places_m = np.random.default_rng(3).uniform(-1.1, 0.8, (60, 2))
    apart = [place for place in places_m if min(np.hypot(*(place - pose[:2])) for pose in EQUILATERAL.values()) > 0.25]
    team.boxes = [rectangle(x_m, y_m, 0.06, 0.09) for x_m, y_m in apart[:20]]
    merged = team.drive(8)
    assert placed(merged) == ["r1", "r2", "r3"]
    assert max(team.error_m(merged, robot) for robot in EQUILATERAL) < 0.01


def test_in_a_wedge_that_drives_straight_on_who_is_behind_does_not_take_the_place_of_who_is_seen() -> None:
    """r2 is seen, and sees not r1 but r4, which sees r2 just where r2 would see r1."""
    wedge = {"r1": Pose2.identity(), "r2": Pose2(-0.35, 0.3, 0.0), "r4": Pose2(-0.7, 0.6, 0.0)}
    team = Team(wedge, seen=[("r1", "r2"), ("r2", "r4"), ("r4", "r2")])
    for _ in range(40):
        merged = team.step(AHEAD)
        for robot in placed(merged):
            assert team.error_m(merged, robot) < 0.05, robot
