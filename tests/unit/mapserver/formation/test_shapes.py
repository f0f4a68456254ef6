"""Shapes of a formation, and who takes which slot."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from mapserver.formation.assignment import assign
from mapserver.formation.shapes import Shape, closest_pair_m, follower_offsets
from protocol.errors import GeometryError
from protocol.geometry import Pose2


def test_a_follower_in_a_wedge_sees_its_neighbour_at_distance_and_angle() -> None:
    (back_m, left_m), (_, right_m) = follower_offsets(Shape("wedge", distance_m=0.5, angle_rad=0.6), 2)
    assert math.hypot(back_m, left_m) == pytest.approx(0.5)
    assert math.atan2(left_m, back_m) == pytest.approx(0.6)
    assert right_m == -left_m


@pytest.mark.parametrize("kind", ["line", "column", "wedge", "polygon"])
@pytest.mark.parametrize("followers", [1, 2, 5, 11])
def test_neighbours_stand_at_their_distance(kind: str, followers: int) -> None:
    offsets = follower_offsets(Shape(kind, distance_m=0.4), followers)  # type: ignore[arg-type]
    assert offsets.shape == (followers, 2)
    assert closest_pair_m(offsets) == pytest.approx(0.4, abs=1e-9)


def test_a_line_turned_left_is_a_column_only_where_nobody_stands_ahead() -> None:
    quarter = Shape("line", distance_m=0.4, turn_rad=math.pi / 2)
    assert follower_offsets(quarter, 1) == pytest.approx(np.array([[0.4, 0.0]]))
    with pytest.raises(GeometryError, match="ahead of its leader"):
        follower_offsets(quarter, 2)


def test_scale_spreads_a_shape() -> None:
    once, twice = (follower_offsets(Shape("polygon", 0.3, scale=scale), 4) for scale in (1.0, 2.0))
    assert np.allclose(twice, 2.0 * once)


def test_free_offsets_are_taken_as_they_are_and_have_to_suffice() -> None:
    shape = Shape("free", offsets=((0.3, 0.1), (0.5, -0.2)))
    assert follower_offsets(shape, 1).tolist() == [[0.3, 0.1]]
    with pytest.raises(GeometryError, match="only 2 free offsets"):
        follower_offsets(shape, 3)


@given(st.integers(0, 10**6))
def test_ways_to_the_slots_do_not_cross(seed: int) -> None:
    random = np.random.default_rng(seed)
    count = int(random.integers(2, 7))
    starts_m, slots_m = random.uniform(-2.0, 2.0, (2, count, 2))
    robots = {f"r{number}": Pose2(float(x_m), float(y_m), 0.0) for number, (x_m, y_m) in enumerate(starts_m)}
    names = assign(robots, slots_m)
    assert sorted(names) == sorted(robots)
    ways = [shapely.LineString([robots[name][:2], slot_m]) for name, slot_m in zip(names, slots_m, strict=True)]
    assert not any(ways[first].crosses(ways[second]) for first in range(count) for second in range(first))
