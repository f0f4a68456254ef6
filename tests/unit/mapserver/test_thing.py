"""When one thing belongs in the map."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from mapserver.mapping.prism import Footprint
from mapserver.mapping.silhouette import SeenHeight
from mapserver.mapping.thing import MOST_HEIGHTS, SHOWN_BELIEF, Thing


@pytest.mark.parametrize(("observations", "told", "is_shown"), [(5, 5, True), (12, 2, False), (12, 3, True), (2000, MOST_HEIGHTS, True)])
def test_what_is_doubted_is_shown_only_where_its_views_tell_its_height(observations: int, told: int, is_shown: bool) -> None:
    base = shapely.box(0.0, 0.0, 0.2, 0.2)
    thing = Thing(0, Footprint(base, np.array([0.1, 0.1]), np.zeros((2, 2))), np.zeros(2), 0.1, 0)
    thing.belief, thing.observations = 2.0 * SHOWN_BELIEF, observations
    thing.heights = [SeenHeight(0.1, 1.0)] * told
    assert thing.is_shown() == is_shown
