"""One local map laid into the arena: which of its regions show a whole base line."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from mapserver.mapping.views.view import TOUCHED_WEIGHT, View, lay
from protocol.geometry import Pose2
from tests.unit.mapserver.worlds import local_map, rectangle, region_of

EYE = Pose2(0.0, 0.0, 0.3)


def view_of(*outlines_m: NDArray[np.float64]) -> View:
    return lay(local_map("r1", 0, regions=[region_of(outline, EYE) for outline in outlines_m]), EYE, [])


def whole(view: View) -> list[bool]:
    return [view.shows_whole(region) for region in view.regions]


def test_what_goes_on_right_behind_another_thing_hides_its_base_line() -> None:
    assert whole(view_of(rectangle(0.7, 0.0, 0.2, 0.3), rectangle(1.0, 0.0, 0.4, 0.3))) == [True, False]


def test_floor_in_between_shows_the_base_line() -> None:
    assert whole(view_of(rectangle(0.7, 0.0, 0.2, 0.3), rectangle(1.1, 0.0, 0.4, 0.3))) == [True, True]


def test_what_touches_beside_another_thing_is_whole() -> None:
    assert whole(view_of(rectangle(0.7, 0.0, 0.2, 0.3), rectangle(0.85, 0.3, 0.2, 0.3))) == [True, True]


def test_the_height_of_what_touches_a_nearer_thing_counts_little() -> None:
    near, beside = rectangle(0.7, 0.0, 0.2, 0.3), rectangle(0.85, 0.3, 0.2, 0.3)

    def weight(*outlines_m: NDArray[np.float64]) -> float:
        view = lay(local_map("r1", 0, regions=[region_of(outline, EYE, height_m=0.1) for outline in outlines_m]), EYE, [])
        height = view.seen_height(view.regions[-1], view.silhouette(view.regions[-1]))
        assert height is not None
        return height.weight

    assert weight(near, beside) == pytest.approx(TOUCHED_WEIGHT * weight(beside))
    assert weight(beside, near) == pytest.approx(weight(near))
