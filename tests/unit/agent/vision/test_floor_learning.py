"""What is learnt of the floor: what is seen all around is floor, what is seen in a few directions is not, however much of it there is."""

from __future__ import annotations

from functools import cache

import cv2
import numpy as np
import pytest

from agent.vision.floor_removal import FloorColours, FloorRemoval
from protocol.geometry import Pose2
from tests.synthetic import CAMERA_HEIGHT_M, FLOOR, Box, Colour, Rendering, render
from tests.unit.agent.eyes import VIEW

BORDER_PX = 4  # nearer to a thing's silhouette the picture shows both
RED: Colour = (110.0, 130.0, 190.0)


@cache
def removal() -> FloorRemoval:
    cv2.setNumThreads(1)
    return FloorRemoval(VIEW, CAMERA_HEIGHT_M)


def mats(count: int) -> tuple[Box, ...]:
    """Return thin mats of one colour, each in another twelfth of all directions."""
    turns = np.arange(count) * np.pi / 6.0
    return tuple(Box(0.45 * np.cos(turn), 0.45 * np.sin(turn), turn, 0.28, 0.15, 0.001, RED) for turn in turns)


def seen(*things: Box, seed: int = 0) -> Rendering:
    return render("paint", Pose2.identity(), things, seed=seed)


def learnt(*pictures: Rendering) -> FloorColours:
    known = None
    for picture in pictures:
        known = removal().remove(VIEW.reduce(picture.picture), known)[1]
    assert known is not None
    return known


def found(picture: Rendering, thing: int = 1, known: FloorColours | None = None) -> float:
    """Return the share of a thing, its border left out, that was told from the floor."""
    mask, _ = removal().remove(VIEW.reduce(picture.picture), known)
    whole = (picture.labels[VIEW.crop] == thing).astype(np.uint8)
    inside = cv2.erode(whole, np.ones((2 * BORDER_PX + 1, 2 * BORDER_PX + 1))) > 0
    return float(mask[inside & VIEW.valid].mean())


@pytest.mark.parametrize("count", [1, 2, 3, 4])
def test_things_of_one_colour_in_a_few_directions_are_things(count: int) -> None:
    picture = seen(*mats(count))
    assert min(found(picture, thing) for thing in range(1, count + 1)) > 0.8


@pytest.mark.parametrize("count", [9, 12])
def test_a_colour_seen_all_around_is_floor(count: int) -> None:
    picture = seen(*mats(count))
    assert max(found(picture, thing) for thing in range(1, count + 1)) < 0.1


def test_a_colour_that_was_floor_is_remembered_for_a_while() -> None:
    assert found(seen(*mats(1), seed=1), known=learnt(seen(*mats(12)))) < 0.1


def test_a_colour_that_is_no_longer_seen_is_forgotten() -> None:
    without = [seen(*mats(1), seed=seed) for seed in range(10)]
    assert found(without[0], known=learnt(seen(*mats(12)), *without)) > 0.8


@pytest.mark.parametrize("tinge", [6.0, 25.0])
def test_a_faint_colour_as_bright_as_the_floor_is_a_thing(tinge: float) -> None:
    assert found(seen(Box(0.5, 0.0, 0.2, 0.2, 0.3, 0.02, (168.0 - tinge, 172.0, 175.0 + tinge)))) > 0.8


@pytest.mark.parametrize("level", [105.0, 225.0])
def test_grey_is_told_from_grey_by_its_brightness(level: float) -> None:
    assert found(seen(Box(0.5, 0.0, 0.2, 0.2, 0.3, 0.02, (0.98 * level, level, 1.02 * level)))) > 0.8


def test_a_wall_that_fills_a_quarter_of_the_view_is_no_floor() -> None:
    assert found(seen(Box(0.9, 0.0, 0.0, 0.4, 1.6, 0.4, (60.0, 110.0, 70.0)))) > 0.95


def test_after_a_picture_without_light_floor_and_things_are_told_again() -> None:
    _, known = removal().remove(np.zeros((*VIEW.valid.shape, 3), np.uint8), None)
    picture = seen(*mats(1))
    mask, _ = removal().remove(VIEW.reduce(picture.picture), known)
    away = VIEW.valid & (VIEW.range_m < 1.5) & (VIEW.bearing_rad < -1.0) & (picture.labels[VIEW.crop] == FLOOR)
    assert mask[away].mean() < 0.01
    assert found(picture, known=known) > 0.8
