"""Pieces of one thing are connected, bearing across and radius up."""

import numpy as np
import pytest
from numpy.typing import ArrayLike

from agent.vision.connection import Pixels, connect_pieces, fills_its_hull
from agent.vision.outlines import find_borders
from tests.unit.agent.floor_worlds import VIEW

CENTRE = np.array([320.0, 320.0])
# A square ahead of the robot, broken in two along its diagonal.
UPPER = [(420, 290), (480, 290), (420, 350)]
LOWER = [(480, 292), (480, 350), (422, 350)]


def piece(corners: ArrayLike, turn_deg: float = 0.0) -> Pixels:
    """Return the border through corners (n, 2) [px], each edge in 20 steps, turned about the point under the camera."""
    given = np.asarray(corners, dtype=np.float64)
    steps = np.linspace(0.0, 1.0, 20, endpoint=False)[:, None]
    border = np.concatenate([a + steps * (b - a) for a, b in zip(given, np.roll(given, -1, axis=0), strict=True)])
    cos, sin = np.cos(np.radians(turn_deg)), np.sin(np.radians(turn_deg))
    turn = np.array([[cos, -sin], [sin, cos]])
    return np.asarray(np.rint((border - CENTRE) @ turn.T + CENTRE), dtype=np.int32)


def rectangle(left: int, top: int, right: int, bottom: int) -> list[tuple[int, int]]:
    return [(left, top), (right, top), (right, bottom), (left, bottom)]


@pytest.mark.parametrize("turn_deg", range(0, 360, 15))  # where bearings wrap around, behind the robot, too
def test_pieces_of_one_thing_are_connected_wherever_it_stands(turn_deg: int) -> None:
    assert connect_pieces([piece(UPPER, turn_deg), piece(LOWER, turn_deg)], CENTRE) == [[0, 1]]


def test_pieces_far_apart_stay_apart() -> None:
    assert connect_pieces([piece(UPPER), piece(LOWER, 180.0), piece(UPPER, 90.0)], CENTRE) == [[0], [1], [2]]


def test_one_thing_behind_another_with_floor_between_stays_apart() -> None:
    assert connect_pieces([piece(rectangle(400, 300, 430, 340)), piece(rectangle(460, 300, 490, 340))], CENTRE) == [[0], [1]]


def test_things_whose_boxes_overlap_but_that_do_not_fill_their_hull_stay_apart() -> None:
    arm, stray = rectangle(400, 316, 500, 324), rectangle(490, 200, 500, 315)
    assert connect_pieces([piece(arm), piece(stray)], CENTRE) == [[0], [1]]


def test_a_small_piece_belongs_to_the_thing_before_it_but_not_to_a_wall() -> None:
    close_by = piece(rectangle(310, 523, 330, 533))
    thing, wall = piece(rectangle(260, 420, 380, 520)), piece(rectangle(120, 420, 520, 520))
    assert connect_pieces([thing, close_by], CENTRE) == [[0, 1]]
    assert connect_pieces([wall, close_by], CENTRE) == [[0], [1]]


def test_a_wall_all_round_is_connected_with_nothing_inside() -> None:
    turn = np.linspace(0.0, 2.0 * np.pi, 60)
    wall = piece(CENTRE + 260.0 * np.stack([np.cos(turn), np.sin(turn)], axis=-1))
    assert connect_pieces([wall, piece(UPPER), piece(LOWER)], CENTRE) == [[0], [1, 2]]


def test_no_pieces_make_no_groups() -> None:
    assert connect_pieces([], CENTRE) == []


def test_a_square_fills_its_hull_and_a_corner_of_two_walls_does_not() -> None:
    assert fills_its_hull([piece(UPPER), piece(LOWER)])
    assert not fills_its_hull([piece([(400, 300), (500, 300), (500, 310), (410, 310), (410, 400), (400, 400)])])


def test_a_thing_broken_by_a_line_of_light_is_one_region() -> None:
    mask = np.zeros(VIEW.valid.shape, np.uint8)
    u, v = np.rint(VIEW.nadir_px).astype(int)
    mask[v - 30 : v + 30, u + 100 : u + 160] = 1
    for step in range(60):
        mask[v - 30 + step, u + 99 + step : u + 102 + step] = 0
    assert len(find_borders(mask, VIEW.nadir_px, 25.0)) == 1
