"""Dirt stays where it is while the floor goes by."""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from agent.vision.lens_dirt import AGREEING, CELL_PX, LOOKS, LensDirt

ROWS, COLS = 30, 40
ROW, COL = np.meshgrid(np.arange(ROWS) - 14.5, np.arange(COLS) - 19.5, indexing="ij")
RADIUS = np.hypot(ROW, COL)
BEARING_RAD = np.arctan2(-COL, -ROW)
FLOOR, BODY = (RADIUS > 4.0) & (RADIUS < 13.0), RADIUS < 3.0
SPOT = (7, 26)  # a cell, row and column
NOBODY = np.empty((0, 2))

Picture = NDArray[np.uint8]
Lens = Callable[[Picture], Picture]


def cells() -> LensDirt:
    return LensDirt(RADIUS, BEARING_RAD, FLOOR, BODY)


def clean(seen: Picture) -> Picture:
    return seen


def spotted(seen: Picture) -> Picture:
    """Return the picture with a dark spot in it, six cells wide."""
    return np.asarray(cv2.circle(seen.copy(), (SPOT[1] * CELL_PX, SPOT[0] * CELL_PX), 12, 50, cv2.FILLED), np.uint8)


def smeared(seen: Picture) -> Picture:
    """Return the picture with a smear in it, six cells wide."""
    mask = cv2.circle(np.zeros(seen.shape, np.uint8), (SPOT[1] * CELL_PX, SPOT[0] * CELL_PX), 12, 1, cv2.FILLED)
    return np.where(mask == 1, cv2.GaussianBlur(seen, (0, 0), 6.0), seen)


def drive(
    dirt: LensDirt, lens: Lens, texture: float = 20.0, looks: int = AGREEING * LOOKS + 1, robots: NDArray[np.float64] = NOBODY
) -> None:
    """Drive over a floor with so much texture [grey levels], and look."""
    rng = np.random.default_rng(3)
    floor = 120.0 + texture * rng.normal(0.0, 1.0, (ROWS * CELL_PX + 500, COLS * CELL_PX))
    shown = np.kron(FLOOR, np.ones((CELL_PX, CELL_PX))) == 1.0
    for number in range(looks):
        seen = np.where(shown, floor[3 * number : 3 * number + ROWS * CELL_PX], 40.0).clip(0, 255).astype(np.uint8)
        dirt.look((lens(seen) + rng.normal(0.0, 1.0, seen.shape)).clip(0, 255).astype(np.uint8), robots)


@pytest.mark.parametrize("lens", [spotted, smeared])
def test_dirt_is_found_where_it_is(lens: Lens) -> None:
    dirt = cells()
    drive(dirt, lens)
    rows, cols = np.nonzero(dirt.dirty)
    assert len(rows) > 5
    assert np.abs(rows - SPOT[0]).max() <= 3
    assert np.abs(cols - SPOT[1]).max() <= 3


def test_clean_lens_is_clean() -> None:
    dirt = cells()
    drive(dirt, clean)
    assert not dirt.dirty.any()


@pytest.mark.parametrize("texture", [0.0, 0.5, 1.0])
def test_on_a_plain_floor_nothing_is_told(texture: float) -> None:
    dirt = cells()
    drive(dirt, spotted, texture)
    assert not dirt.dirty.any()


def test_one_verdict_alone_is_not_told() -> None:
    dirt = cells()
    drive(dirt, spotted, looks=LOOKS + 1)
    assert not dirt.dirty.any()


def test_robot_that_drives_along_is_no_dirt() -> None:
    dirt = cells()
    bearing_rad = BEARING_RAD[SPOT]
    drive(dirt, spotted, robots=np.array([[bearing_rad, 0.6]]))
    assert not dirt.dirty.any()
