"""Somebody who walks through."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from sim.world.people import STRIDE_M, Walker

WALKER = Walker("ann", np.array([(0.0, 0.0), (2.0, 0.0), (2.0, 1.0)]), speed_m_s=0.5, starts_at_s=2.0, rgb=(1, 2, 3))


@pytest.mark.parametrize("time_s", [0.0, 1.99, 8.01, 100.0])
def test_nobody_is_there_before_and_after_the_walk(time_s: float) -> None:
    assert WALKER.legs(time_s) == ()


@pytest.mark.parametrize("time_s", [2.0, 3.3, 4.7, 5.0])
def test_both_legs_are_where_the_walk_has_come_to(time_s: float) -> None:
    legs = WALKER.legs(time_s)
    assert [leg.name for leg in legs] == ["ann-left", "ann-right"]
    centre = np.mean([leg.footprint_m.mean(axis=0) for leg in legs], axis=0)
    assert centre == pytest.approx((0.5 * (time_s - 2.0), 0.0), abs=1e-9)


def test_one_leg_stands_while_the_other_swings() -> None:
    stride_s = STRIDE_M / 0.5
    earlier, later = WALKER.legs(2.0 + 0.1 * stride_s), WALKER.legs(2.0 + 0.4 * stride_s)
    moved_m = [float(b.footprint_m[0, 0] - a.footprint_m[0, 0]) for a, b in zip(earlier, later, strict=True)]
    assert moved_m == pytest.approx([0.6 * STRIDE_M, 0.0])


def test_legs_are_convex_counter_clockwise_and_apart() -> None:
    left, right = (leg.footprint_m for leg in WALKER.legs(7.0))
    for footprint in (left, right):
        edges = np.roll(footprint, -1, axis=0) - footprint
        following = np.roll(edges, -1, axis=0)
        assert (edges[:, 0] * following[:, 1] - edges[:, 1] * following[:, 0] > 0.0).all()
    assert shapely.Polygon(left).distance(shapely.Polygon(right)) > 0.05
