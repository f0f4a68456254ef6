"""What of some cells belongs to one convex thing."""

import numpy as np
import pytest

from mapserver.mapping.footprints.carving import MOST_SAMPLES, carved

SIZE = 120


def worth(positive: tuple[slice, slice], *negative: tuple[slice, slice]) -> np.ndarray[tuple[int, int], np.dtype[np.float32]]:
    cells = np.zeros((SIZE, SIZE), np.float32)
    for place in negative:
        cells[place] = -1.0
    cells[positive] = 1.0
    return cells


def box_of(corners: np.ndarray[tuple[int, ...], np.dtype[np.int_]]) -> list[int]:
    return [*corners.min(axis=0).tolist(), *corners.max(axis=0).tolist()]


def test_where_nothing_speaks_against_it_the_hull_stays() -> None:
    cells = worth((slice(20, 60), slice(30, 50)))
    cells[80, 90] = 1.0
    assert box_of(carved(cells)) == [30, 20, 90, 80]


def test_a_few_cells_beyond_much_that_speaks_against_the_thing_are_cut_off() -> None:
    cells = worth((slice(20, 60), slice(30, 60)), (slice(0, SIZE), slice(60, 110)))
    cells[40:43, 110:113] = 1.0
    left, _, right, _ = box_of(carved(cells))
    assert (left, right) == (30, 59)


def test_cells_beyond_little_that_speaks_against_the_thing_are_kept() -> None:
    cells = worth((slice(20, 60), slice(30, 60)), (slice(20, 60), slice(60, 62)))
    cells[20:60, 62:80] = 1.0
    assert box_of(carved(cells))[2] == 79


def test_cells_that_speak_louder_are_kept() -> None:
    cells = worth((slice(20, 60), slice(30, 60)), (slice(20, 60), slice(60, 70)))
    cells[20:60, 70] = 4.0
    assert box_of(carved(cells))[2] == 59
    cells[20:60, 70] = 20.0
    assert box_of(carved(cells))[2] == 70


def test_something_is_always_left() -> None:
    cells = np.full((SIZE, SIZE), -1.0, np.float32)
    cells[50, 50] = cells[60, 61] = 1.0
    assert len(carved(cells)) >= 1


def test_a_large_thing_is_carved_by_samples() -> None:
    cells = np.zeros((400, 400), np.float32)
    cells[50:350, 50:200], cells[50:350, 200:380] = 1.0, -1.0
    cells[200:203, 380:383] = 1.0
    assert cells.size > 2 * MOST_SAMPLES
    assert box_of(carved(cells))[2] == pytest.approx(199, abs=4)
