"""Things that touch in the picture though they stand apart, and things that only look as if."""

import cv2
import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray

from agent.vision.depth_steps import cut_at_depth_steps
from protocol.geometry import Array
from tests.unit.agent.floor_worlds import VIEW, box, disc, seen, upright

STEP_M = 0.08


def covered(*things: ArrayLike) -> NDArray[np.uint8]:
    """Return the mask of several upright things, each given by its corners."""
    return np.asarray(np.maximum.reduce([seen(thing) for thing in things]), np.uint8)


def aside(footprint: ArrayLike, y_m: float) -> Array:
    return np.add(footprint, (0.0, y_m))


def parts(mask: NDArray[np.uint8]) -> int:
    return int(cv2.connectedComponents(cut_at_depth_steps(mask, VIEW, STEP_M), connectivity=8)[0]) - 1


def test_a_thing_that_looks_out_from_behind_another_is_cut_off() -> None:
    front, behind = upright(box(0.6, 0.7, 0.1), 0.15), upright(aside(box(0.95, 1.1, 0.15), 0.2), 0.15)
    mask = covered(front, behind)
    assert cv2.connectedComponents(mask)[0] == 2
    assert parts(mask) == 2


def test_what_is_cut_off_keeps_its_own_base_line() -> None:
    front, behind = upright(box(0.6, 0.7, 0.1), 0.15), upright(aside(box(0.95, 1.1, 0.15), -0.2), 0.15)
    opened = cut_at_depth_steps(covered(front, behind), VIEW, STEP_M)
    _, numbers = cv2.connectedComponents(opened, connectivity=8)
    nearest = sorted(float(VIEW.range_m[numbers == number].min()) for number in (1, 2))
    assert nearest[0] == pytest.approx(0.6, abs=0.01)
    assert nearest[1] == pytest.approx(np.hypot(0.95, 0.16), abs=0.02)


def test_the_cut_takes_little() -> None:
    mask = covered(upright(box(0.6, 0.7, 0.1), 0.15), upright(aside(box(0.95, 1.1, 0.15), 0.2), 0.15))
    opened = cut_at_depth_steps(mask, VIEW, STEP_M)
    assert not (opened & ~mask).any()
    assert opened.sum() > 0.97 * mask.sum()


@pytest.mark.parametrize("height_m", [0.05, 0.2, 0.4])
@pytest.mark.parametrize("turn_rad", [0.0, 0.4, 0.785, 2.0])
def test_one_box_is_never_cut(height_m: float, turn_rad: float) -> None:
    turned = cv2.boxPoints(((0.8, 0.1), (0.3, 0.12), float(np.degrees(turn_rad)))).astype(np.float64)
    mask = seen(upright(turned, height_m))
    assert cut_at_depth_steps(mask, VIEW, STEP_M) is mask


@pytest.mark.parametrize("x_m", [0.3, -0.5, -1.2])
def test_a_round_thing_is_never_cut_in_front_or_behind(x_m: float) -> None:
    mask = seen(upright(disc(x_m, 0.0, 0.08), 0.3))
    assert cut_at_depth_steps(mask, VIEW, STEP_M) is mask


def test_things_that_touch_without_a_leap_stay_one() -> None:
    assert parts(covered(upright(box(0.6, 0.7, 0.1), 0.1), upright(aside(box(0.62, 0.8, 0.1), 0.2), 0.1))) == 1


def test_a_splinter_beside_a_thing_is_no_other_thing() -> None:
    front, splinter = upright(box(0.6, 0.7, 0.1), 0.15), upright(aside(box(0.95, 1.0, 0.01), 0.155), 0.05)
    assert parts(covered(front, splinter)) == 1


def test_an_empty_mask_stays_empty() -> None:
    assert not cut_at_depth_steps(np.zeros(VIEW.valid.shape, np.uint8), VIEW, STEP_M).any()
