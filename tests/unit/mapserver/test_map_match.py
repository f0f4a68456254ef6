"""A view fits the map where its base lines lie on mapped ones, and nowhere else."""

from __future__ import annotations

import numpy as np
import pytest

from mapserver.mapping.joining.map_match import MapField, base_lines, match_nats
from protocol.geometry import Array, Pose2
from protocol.messages import FREE, OCCUPIED, UNKNOWN, LocalMap
from tests.unit.mapserver.worlds import local_map, rectangle, region_of, smear_of

EYE = Pose2(2.0, 1.5, 0.7)
BOXES = [rectangle(2.6, 1.7, 0.2, 0.3), rectangle(1.7, 2.2, 0.3, 0.1), rectangle(2.1, 0.8, 0.15, 0.15)]


def mapped(elsewhere: int = FREE) -> MapField:
    """Return the map of the boxes on a floor of 4 m x 3 m."""
    cells = np.full((300, 400), elsewhere, np.uint8)
    for box in BOXES:
        (left, low), (right, high) = (np.rint(corner * 100).astype(int) for corner in (box[0], box[2]))
        cells[low:high, left:right] = OCCUPIED
    return MapField(cells, np.zeros(2))


def view(motion: str = "static") -> LocalMap:
    regions = [region_of(smear_of(box, 0.15, EYE), EYE).model_copy(update={"motion": motion}) for box in BOXES]
    return local_map("r2", 0, regions=regions)


def nats(*poses: Pose2, field: MapField | None = None) -> Array:
    return match_nats(base_lines(view()), np.array(poses), field or mapped())


def test_the_true_pose_is_likelier_than_others() -> None:
    true, shifted, turned = nats(EYE, EYE @ Pose2(0.3, 0.0, 0.0), EYE @ Pose2(0.0, 0.0, 0.8))
    assert true > 4.0
    assert max(shifted, turned) < 0.5


def test_a_centimetre_off_is_nearly_as_likely() -> None:
    true, near = nats(EYE, EYE @ Pose2(0.01, 0.0, 0.01))
    assert near == pytest.approx(true, abs=1.0)


def test_an_unknown_map_says_nothing() -> None:
    nowhere = MapField(np.full((10, 10), UNKNOWN, np.uint8), np.zeros(2))
    assert nats(EYE, YONDER := Pose2(50.0, 0.0, 0.0), field=nowhere) == pytest.approx([0.0, 0.0])
    assert nats(YONDER) == pytest.approx([0.0])


def test_the_base_line_is_the_border_that_faces_the_robot() -> None:
    lines = base_lines(view())
    points_m = EYE.apply(lines.points_m)
    assert len(np.unique(lines.things)) == len(BOXES)
    on_box = [np.min([np.abs(np.clip(p, box[0], box[2]) - p).max() for box in BOXES]) for p in points_m]
    assert np.mean(np.array(on_box) < 0.01) > 0.9


def test_what_moves_and_what_is_not_there_says_nothing() -> None:
    assert len(base_lines(view("moving")).things) == 0
    assert match_nats(base_lines(local_map("r2", 0)), np.array([EYE]), mapped()) == pytest.approx([0.0])
