"""Where bare floor showed lately."""

from __future__ import annotations

import numpy as np
import pytest

from agent.control.bare_floor import BEYOND_M, LEAST_VIEWS, MOST_RANGE_M, VIEWS, BareFloor
from protocol.geometry import Array, Pose2
from protocol.messages import LocalMap
from tests.unit.agent.control.local_maps import HIDDEN_M, box, local_map, region, sighting

RADIUS_M = 0.075
THING = [region(box(0.32, 0.0, 0.1, 0.1)), region(box(-0.4, 0.3), label=2)]
BORDER = np.array([(0.27, 0.02)])  # its near side


def tells(points_m: Array, *maps: LocalMap) -> list[bool]:
    bare_floor = BareFloor(RADIUS_M)
    for each in maps:
        bare_floor.note(each)
    return [bool(each) for each in bare_floor.mostly(points_m)]


@pytest.mark.parametrize(("with_thing", "is_bare"), [(0, True), (4, True), (5, False), (10, False)])
def test_the_most_of_the_last_maps_decide(with_thing: int, is_bare: bool) -> None:
    before = [local_map(step, THING) for step in range(VIEWS)]
    last = [local_map(VIEWS + step, THING if step < with_thing else ()) for step in range(VIEWS)]
    assert tells(BORDER, *before, *last) == [is_bare]


def test_a_few_maps_tell_nothing() -> None:
    maps = [local_map(step) for step in range(LEAST_VIEWS)]
    assert tells(BORDER, *maps[1:]) == [False]
    assert tells(BORDER, *maps) == [True]


def test_only_what_was_in_view_counts() -> None:
    too_near, too_far = np.array([(HIDDEN_M - 0.01, 0.0), (0.0, MOST_RANGE_M + 0.01)])
    assert tells(np.array([too_near, too_far]), *(local_map(step) for step in range(VIEWS))) == [False, False]


def test_it_is_told_where_things_are_while_the_robot_drives() -> None:
    poses = [Pose2(0.01 * step - 0.1, 0.002 * step, 0.03 * step) for step in range(VIEWS)]
    maps = [
        local_map(step, [region(pose.inverse().apply(box(0.32, 0.0, 0.1, 0.1)))], odom_from_body=pose) for step, pose in enumerate(poses)
    ]
    assert tells(np.array([BORDER[0], (0.27, 0.1)]), *maps) == [False, True]


def test_behind_a_border_is_no_bare_floor_and_before_it_is() -> None:
    maps = [local_map(step, THING) for step in range(VIEWS)]
    assert tells(BORDER - (0.5 * BEYOND_M, 0.0), *maps) == [False]
    assert tells(BORDER - (2.0 * BEYOND_M, 0.0), *maps) == [True]


def test_where_a_robot_is_sighted_is_no_bare_floor() -> None:
    maps = [local_map(step, sightings=[sighting(0.3, 0.0)]) for step in range(VIEWS)]
    assert tells(np.array([(0.3 - RADIUS_M, 0.0), (0.3, 0.1)]), *maps) == [False, True]
