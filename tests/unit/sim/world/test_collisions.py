"""Clearances against shapely's distances, and how contacts are counted."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from protocol.geometry import Array
from sim.world.collisions import Contacts, Near, Obstacles, clearance_m, is_blocked
from sim.world.scene import Thing

RADIUS_M = 0.075
coordinates = st.floats(-2.0, 2.0)


def polygon(sides: int, radius_m: float, turn_rad: float) -> Array:
    angles = turn_rad + np.arange(sides) * 2.0 * math.pi / sides
    return np.column_stack((radius_m * np.cos(angles), 0.5 * radius_m * np.sin(angles)))


def thing(name: str, x_m: float) -> Thing:
    footprint = np.array([(x_m, -0.1), (x_m + 0.2, -0.1), (x_m + 0.2, 0.1), (x_m, 0.1)])
    return Thing(name, "box", footprint, 0.1, (0, 0, 0), "plain")


@given(coordinates, coordinates, st.integers(3, 32), st.floats(0.05, 1.5), st.floats(0.0, math.pi))
def test_clearance_is_the_distance_to_the_edge(x_m: float, y_m: float, sides: int, radius_m: float, turn_rad: float) -> None:
    footprint = polygon(sides, radius_m, turn_rad)
    place, solid = shapely.Point(x_m, y_m), shapely.Polygon(footprint)
    expected = place.distance(solid) or -place.distance(solid.exterior)
    assert clearance_m((x_m, y_m), footprint) == pytest.approx(expected, abs=1e-9)


def test_only_what_is_within_reach_is_near() -> None:
    obstacles = Obstacles([thing("here", 0.2), thing("there", 1.0)])
    [near] = obstacles.near((0.0, 0.0), (0.11, 0.0), reach_m=0.1)
    assert near.name == "here"
    assert (near.before_m, near.after_m) == pytest.approx((0.2, 0.09))


def test_nothing_is_near_where_there_is_nothing() -> None:
    assert Obstacles([]).near((0.0, 0.0), (0.0, 0.0), 1.0) == []


def test_a_body_may_leave_what_it_overlaps_but_not_go_deeper() -> None:
    assert is_blocked(Near("box", before_m=0.05, after_m=0.04), RADIUS_M)
    assert not is_blocked(Near("box", before_m=0.04, after_m=0.05), RADIUS_M)
    assert not is_blocked(Near("box", before_m=0.09, after_m=0.08), RADIUS_M)


def test_a_contact_counts_once_however_long_it_lasts() -> None:
    contacts = Contacts()
    pushing = Near("box", 0.0755, 0.0745)
    assert contacts.meet([pushing], RADIUS_M) == ["box"]
    assert contacts.meet([pushing], RADIUS_M) == []
    assert contacts.meet([Near("box", 0.0755, 0.0770)], RADIUS_M) == []  # not yet away
    assert contacts.meet([pushing], RADIUS_M) == []
    assert contacts.count == 1


def test_a_contact_counts_again_after_the_body_has_come_away() -> None:
    contacts = Contacts()
    contacts.meet([Near("box", 0.0755, 0.0745)], RADIUS_M)
    contacts.meet([Near("box", 0.0755, 0.0901)], RADIUS_M)
    assert contacts.meet([Near("box", 0.0755, 0.0745)], RADIUS_M) == ["box"]
    assert contacts.count == 2


def test_a_body_that_stands_has_run_into_nothing() -> None:
    contacts = Contacts()
    assert contacts.meet([Near("person-left", 0.05, 0.05)], RADIUS_M) == []
    assert contacts.count == 0


def test_two_things_touched_at_once_are_two_contacts() -> None:
    contacts = Contacts()
    assert contacts.meet([Near("wall", 0.076, 0.074), Near("box", 0.076, 0.074)], RADIUS_M) == ["box", "wall"]
