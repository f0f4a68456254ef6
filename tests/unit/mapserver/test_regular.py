"""Footprints as circles and rectangles: what is round or right-angled is completed from one side, what is neither is left as it is."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest
import shapely
from numpy.typing import NDArray

from mapserver.mapping.footprints.prism import Footprint, Ground, footprint
from mapserver.mapping.footprints.regular import regular
from mapserver.mapping.views.silhouette import Silhouette
from protocol.geometry import Array, Pose2
from tests.unit.mapserver.worlds import CAMERA_HEIGHT_M, rectangle, smear_of

HEIGHT_M = 0.15
TURNED = Pose2(0.3, -0.2, 0.4)
BOX = TURNED.apply(rectangle(0.0, 0.0, 0.24, 0.20))
TURNS = np.linspace(0.0, 2.0 * math.pi, 40, endpoint=False)
CYLINDER = np.array(TURNED[:2]) + 0.07 * np.stack([np.cos(TURNS), np.sin(TURNS)], axis=-1)
WEDGE = TURNED.apply(np.array([(-0.1, -0.15), (0.25, -0.15), (-0.1, 0.2)]))
ALL_ROUND = [(0.3 + 0.9 * math.cos(a), -0.2 + 0.9 * math.sin(a)) for a in np.linspace(0.0, 2.0 * math.pi, 12, endpoint=False)]
ONE_SIDE = [(-0.6, -0.5), (-0.7, -0.2), (-0.6, 0.1)]
NO_BASE = np.empty((0, 2))


def nowhere_bare(x_m: Array, y_m: Array) -> NDArray[np.bool_]:
    return np.zeros((len(y_m), len(x_m)), np.bool_)


def seen_from(eye_m: tuple[float, float], base_m: Array, grown_m: float = 0.0) -> Silhouette:
    outline = shapely.buffer(shapely.Polygon(smear_of(base_m, HEIGHT_M, Pose2(*eye_m, 0.0))), grown_m, join_style="mitre")
    return Silhouette(np.array(eye_m), CAMERA_HEIGHT_M, outline, 0.5)


def fitted(views: Sequence[Silhouette], ground: Ground) -> tuple[Footprint, Footprint | None]:
    """Return the rough footprint, and the circle or rectangle that takes its place."""
    rough = footprint(views, HEIGHT_M, ground)
    assert rough is not None
    return rough, regular(rough, views, HEIGHT_M, ground)


def iou(found: Footprint, base_m: Array) -> float:
    truth = shapely.Polygon(base_m)
    return float(found.base.intersection(truth).area / found.base.union(truth).area)


@pytest.mark.parametrize("base_m", [BOX, CYLINDER])
@pytest.mark.parametrize("eyes", [ALL_ROUND, ONE_SIDE])
def test_boxes_and_cylinders_come_out_whole_from_all_sides_and_from_one(base_m: Array, eyes: Sequence[tuple[float, float]]) -> None:
    _, found = fitted([seen_from(eye, base_m) for eye in eyes], Ground(nowhere_bare, NO_BASE))
    assert found is not None
    assert iou(found, base_m) > 0.95
    assert np.hypot(*(found.centre_m - TURNED[:2])) < 0.003


def test_outlines_that_take_in_a_shadow_on_one_side_are_outvoted() -> None:
    views = [seen_from(eye, CYLINDER, grown_m=0.03 if index < 3 else 0.0) for index, eye in enumerate(ALL_ROUND)]
    _, found = fitted(views, Ground(nowhere_bare, NO_BASE))
    assert found is not None
    assert iou(found, CYLINDER) > 0.95


def test_what_is_neither_round_nor_right_angled_has_no_regular_footprint() -> None:
    _, found = fitted([seen_from(eye, WEDGE) for eye in ALL_ROUND], Ground(nowhere_bare, NO_BASE))
    assert found is None


def test_views_that_contradict_each_other_tell_no_regular_footprint() -> None:
    scattered = [seen_from(eye, BOX + 0.15 * np.array([math.cos(2.0 * turn), math.sin(3.0 * turn)])) for turn, eye in enumerate(ALL_ROUND)]
    _, found = fitted(scattered, Ground(nowhere_bare, NO_BASE))
    assert found is None


def test_a_shape_that_leaves_the_base_line_is_not_taken() -> None:
    behind = TURNED.apply(np.stack(np.meshgrid(np.arange(0.08, 0.2, 0.01), np.arange(-0.1, 0.1, 0.01)), axis=-1).reshape(-1, 2))
    _, found = fitted([seen_from(eye, BOX) for eye in ONE_SIDE], Ground(nowhere_bare, behind))
    assert found is None


def test_a_wall_has_no_regular_footprint() -> None:
    base_line = np.stack([np.full(70, 0.0), np.arange(-0.35, 0.35, 0.01)], axis=-1)
    _, found = fitted([seen_from(eye, rectangle(0.05, 0.0, 0.1, 0.7)) for eye in ONE_SIDE], Ground(nowhere_bare, base_line))
    assert found is None


def test_how_far_single_views_are_off_is_counted_from_the_new_centre() -> None:
    rough, found = fitted([seen_from(eye, CYLINDER) for eye in ONE_SIDE], Ground(nowhere_bare, NO_BASE))
    assert found is not None
    moved_m = rough.centre_m - found.centre_m
    np.testing.assert_allclose(found.disagreement, rough.disagreement + np.outer(moved_m, moved_m))
