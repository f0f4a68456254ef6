"""One local map laid into the arena: which of its regions show a whole base line."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mapserver.mapping.view import View, lay
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
