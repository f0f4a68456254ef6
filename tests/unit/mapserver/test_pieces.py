"""Pieces of one thing on the map."""

from __future__ import annotations

import numpy as np
import shapely

from mapserver.mapping.footprints.prism import Footprint
from mapserver.mapping.things.pieces import PIECE_GAP_M, wholes
from mapserver.mapping.things.thing import Thing


def piece(number: int, x_m: float, height_m: float = 0.1, length_m: float = 0.1, observations: int = 10) -> Thing:
    """Return a thing from `x_m` on, as long along x, seen by a robot of its own."""
    base = shapely.box(x_m, 0.0, x_m + length_m, 0.1)
    thing = Thing(number, Footprint(base, np.array([x_m + 0.5 * length_m, 0.05]), np.zeros((2, 2))), np.array([x_m, 0.0]), height_m, 0)
    thing.observations, thing.seen_by = observations, {f"r{number}"}
    return thing


def test_pieces_of_one_height_close_together_are_one_thing_under_the_older_number() -> None:
    (whole,) = wholes([piece(3, 0.0), piece(5, 0.1 + 0.9 * PIECE_GAP_M, observations=40)])
    assert (whole.number, whole.observations, whole.seen_by) == (3, 40, {"r3", "r5"})
    assert whole.shape.base.covers(shapely.box(0.0, 0.0, 0.2, 0.1))


def test_what_stands_apart_or_is_not_as_tall_is_another_thing() -> None:
    assert [thing.number for thing in wholes([piece(0, 0.0), piece(1, 0.1 + 1.1 * PIECE_GAP_M)])] == [0, 1]
    assert [thing.number for thing in wholes([piece(0, 0.0), piece(1, 0.15, height_m=0.2)])] == [0, 1]


def test_stretches_of_a_wall_stay_apart() -> None:
    assert len(wholes([piece(0, 0.0, length_m=0.5), piece(1, 0.55, length_m=0.5)])) == 2


def test_things_stay_as_they_are_when_they_are_put_together_for_the_map() -> None:
    things = [piece(0, 0.0), piece(1, 0.15)]
    wholes(things)
    assert [thing.shape.base.area for thing in things] == [shapely.box(0.0, 0.0, 0.1, 0.1).area] * 2
