"""Two views prove what lies in the floor."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from agent.slam.floor_memory import VIEWS, FloorMemory
from agent.vision.floor_view import Picture
from agent.vision.hull import convex_hull
from protocol.geometry import Array, Pose2
from tests.synthetic import BODY_RADIUS_M, CAMERA_HEIGHT_M, Box, Cylinder, render
from tests.unit.agent.eyes import PATCH, VIEW

EYE_M = np.zeros(2)
WOOD = (86.0, 126.0, 168.0)
NOBODY = np.empty((0, 2))
BEFORE, NOW = Pose2.identity(), Pose2(0.12, 0.05, 0.2)


def from_above(pose: Pose2, floor: str, *solids: Box | Cylinder) -> Picture:
    return PATCH.sample(np.asarray(cv2.cvtColor(render(floor, pose, solids).picture, cv2.COLOR_BGR2GRAY), np.uint8))


def square(x_m: float, y_m: float, pose: Pose2) -> Array:
    """Return the outline of a square of 8 cm about a place of the floor, as it lies before a robot at `pose`."""
    return pose.inverse().apply(
        np.array([(x_m - 0.04, y_m - 0.04), (x_m + 0.04, y_m - 0.04), (x_m + 0.04, y_m + 0.04), (x_m - 0.04, y_m + 0.04)])
    )


def told(
    floor: str, *solids: Box | Cylinder, before: Pose2 = BEFORE, robots_m: Array = NOBODY, place_m: tuple[float, float] = (0.4, 0.1)
) -> bool | None:
    memory = FloorMemory(PATCH, VIEW.body_range_m, BODY_RADIUS_M, EYE_M)
    memory.remember(from_above(before, floor, *solids), robots_m, before)
    return memory.lies_flat(square(*place_m, NOW), from_above(NOW, floor, *solids), NOW)


@pytest.mark.parametrize("floor", ["grid", "wood", "paint", "concrete"])
def test_the_floor_lies_flat(floor: str) -> None:
    assert told(floor) is True


@pytest.mark.parametrize("height_m", [0.04, 0.1, 0.15])
def test_what_stands_does_not_though_it_has_the_floors_own_colour(height_m: float) -> None:
    post = Cylinder(0.4, 0.1, 0.04, height_m, WOOD)
    turns = np.linspace(0.0, 2.0 * np.pi, 40)
    base_m = NOW.inverse().apply(np.column_stack([post.x_m + post.reach_m * np.cos(turns), post.y_m + post.reach_m * np.sin(turns)]))
    outline_m = convex_hull(np.concatenate([base_m, CAMERA_HEIGHT_M / (CAMERA_HEIGHT_M - height_m) * base_m]))
    memory = FloorMemory(PATCH, VIEW.body_range_m, BODY_RADIUS_M, EYE_M)
    memory.remember(from_above(BEFORE, "wood", post), NOBODY, BEFORE)
    assert memory.lies_flat(outline_m, from_above(NOW, "wood", post), NOW) is False


def test_nothing_is_told_from_where_the_camera_is_now() -> None:
    assert told("wood", before=Pose2(NOW.x_m - 0.1 * CAMERA_HEIGHT_M, NOW.y_m, 0.0)) is None


def test_nothing_is_told_of_what_was_out_of_sight() -> None:
    assert told("wood", place_m=(0.12, 0.18)) is None  # beside the body now, under it before


def test_nothing_is_told_of_what_a_robot_hid() -> None:
    assert told("wood", robots_m=np.array([[0.3, 0.075]])) is None
    assert told("wood", robots_m=np.array([[0.3, -0.3]])) is True


def test_the_last_views_are_kept_of_which_each_is_from_a_place_of_its_own() -> None:
    memory = FloorMemory(PATCH, VIEW.body_range_m, BODY_RADIUS_M, EYE_M)
    blank = np.zeros(PATCH.points_m.shape[:2], np.uint8)
    memory.remember(from_above(BEFORE, "wood"), NOBODY, BEFORE)
    outline_m, floor = square(0.4, 0.1, NOW), from_above(NOW, "wood")
    for step in range(20):
        memory.remember(blank, NOBODY, Pose2(0.001 * step, 0.0, 0.1 * step))
    assert memory.lies_flat(outline_m, floor, NOW)
    for step in range(VIEWS):
        memory.remember(blank, NOBODY, Pose2(0.0, -0.06 * step - 0.06, 0.0))
    assert not memory.lies_flat(outline_m, floor, NOW)
