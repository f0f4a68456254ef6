"""From when there is room until a formation that gave way is whole."""

from __future__ import annotations

import math

import numpy as np
import pytest

from deploy.evaluation.formation_restored import Whole, how_whole, restored_s
from deploy.evaluation.formation_room import OpenSlots

STEP_NS = 100_000_000


def moments(room: str, off_cm: str) -> list[Whole]:
    """Return a moment for each character: # where there is room, and by how many centimetres the formation is not whole."""
    return [Whole(STEP_NS * step, there == "#", 0.01 * int(off)) for step, (there, off) in enumerate(zip(room, off_cm, strict=True))]


@pytest.mark.parametrize(
    ("room", "off_cm", "took_s"),
    [
        ("..######", "09973111", [0.3]),  # from the first moment with room to that in which all are within two centimetres
        ("...#.###", "09999311", [0.1]),  # room that ended before does not count
        ("########", "00997100", [0.3]),  # who gives way though there is room is judged from then on
        ("########", "00444000", []),  # four centimetres off is no giving way
        ("........", "09999000", []),
        ("##..##..", "91008100", [0.1, 0.1]),
    ],
)
def test_it_takes_from_when_there_is_room_until_it_is_whole(room: str, off_cm: str, took_s: list[float]) -> None:
    assert restored_s(moments(room, off_cm)) == pytest.approx(took_s)


def test_room_that_is_left_unused_for_long_counts_as_long_as_it_lasted() -> None:
    assert restored_s(moments("#" * 120 + ".", "9" * 121)) == pytest.approx([12.0])
    assert restored_s(moments("#" * 90 + ".", "9" * 91)) == []


def test_every_follower_is_judged_by_the_slot_that_is_best_for_all() -> None:
    slots = OpenSlots(np.array([[0.0, 0.0], [1.0, 0.0]]), have_room=True)
    whole = how_whole(5, np.array([[1.01, 0.0], [0.0, 0.03]]), slots)
    assert (whole.stamp_ns, whole.has_room) == (5, True)
    assert whole.off_m == pytest.approx(0.03)


def test_nothing_is_known_before_the_formation_is_under_way() -> None:
    early = how_whole(5, np.zeros((1, 2)), None)
    assert (early.has_room, math.isnan(early.off_m)) == (False, True)
