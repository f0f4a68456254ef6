"""The formation's score: followers against their slots, laid at the true leader."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import shapely

from deploy.evaluation.formation_metrics import SlotRow, read_slots, score_formation
from deploy.evaluation.formation_room import OpenSlots, Room
from deploy.evaluation.truth import Obstacle, Truth
from deploy.evaluation.tum import Trajectory
from deploy.formation_log import FORMATION_FILE, FormationLog
from protocol.errors import RecordingError
from protocol.messages import FormationState, Slot

STEP_NS = 100_000_000
SLOT = (-0.4, 0.2)


def still(x_m: float, y_m: float, theta_rad: float, steps: int) -> Trajectory:
    return Trajectory(STEP_NS * np.arange(steps, dtype=np.int64), np.tile([x_m, y_m, theta_rad], (steps, 1)))


def rows(phases: list[str], slots: list[tuple[float, float]]) -> list[SlotRow]:
    pairs = enumerate(zip(phases, slots, strict=True))
    return [SlotRow(STEP_NS * step, phase, "r1", "r2", slot) for step, (phase, slot) in pairs]


def test_a_follower_is_judged_against_its_slot_at_the_leader_as_it_truly_faces() -> None:
    truth = {"r1": still(1.0, 1.0, math.pi / 2.0, 2), "r2": still(0.8, 0.63, 0.0, 2)}  # the slot lies at (0.8, 0.6)
    score = score_formation(rows(["moving", "avoiding"], [SLOT, SLOT]), truth)
    assert score is not None
    assert (score.steady_rms_m, score.avoiding_rms_m, score.worst_m) == pytest.approx((0.03, 0.03, 0.03))
    assert score.phases == ("moving", "avoiding")


def test_gathering_does_not_count() -> None:
    truth = {"r1": still(0.0, 0.0, 0.0, 2), "r2": still(5.0, 5.0, 0.0, 2)}
    assert score_formation(rows(["gathering", "arrived"], [SLOT, SLOT]), truth) is None


def straight(length_m: float) -> Trajectory:
    """Return a drive along x, a centimetre a stamp."""
    x_m = np.arange(0.0, length_m, 0.01)
    return Trajectory(STEP_NS * np.arange(len(x_m), dtype=np.int64), np.column_stack([x_m, 0.0 * x_m, 0.0 * x_m]))


def test_what_a_formation_calls_itself_does_not_make_it_whole() -> None:
    aside_m = np.array([0.2] * 10 + [0.3] * 10 + [0.2] * 10)
    follower = Trajectory(STEP_NS * np.arange(30, dtype=np.int64), np.column_stack([np.full(30, -0.4), aside_m, np.zeros(30)]))
    truth = {"r1": still(0.0, 0.0, 0.0, 30), "r2": follower}
    for phases in (["moving"] * 30, ["avoiding"] * 30):
        score = score_formation(rows(phases, [SLOT] * 30), truth, lambda leader, stamp_ns: OpenSlots(np.array([SLOT]), have_room=True))
        assert score is not None
        assert score.restored_s == pytest.approx((1.0,))


def test_there_is_room_where_the_open_slots_are_clear_of_things() -> None:
    thing = Obstacle(0, "box", shapely.box(1.0, 0.25, 1.1, 0.35), 0.1, None)
    truth = Truth("drive", shapely.box(-1.0, -1.0, 3.0, 1.0), (thing,), {"r1": straight(2.0)}, {"r1": 0.075})
    room = Room(truth, np.array([[0.4, 0.2], [0.4, -0.2]]))
    early, *later = (room.slots("r1", STEP_NS * step) for step in (20, 100, 145, 190))
    assert early is None
    assert [slots is not None and slots.have_room for slots in later] == [True, False, True]
    assert later[0] is not None
    assert later[0].places_m == pytest.approx(np.array([[0.6, 0.2], [0.6, -0.2]]))
    assert room.slots("r2", 0) is None


def test_what_was_logged_is_read_back_once_for_each_stamp(tmp_path: Path) -> None:
    slots = (Slot(robot="r1", leader_from_slot=(0.0, 0.0)), Slot(robot="r2", leader_from_slot=SLOT))
    state = FormationState(epoch=1, seq=0, stamp_ns=STEP_NS, phase="moving", reason="", leader="r1", goal=(1.0, 0.0), slots=slots)
    with FormationLog(tmp_path) as log:
        log.add(state)
        log.add(state.model_copy(update={"seq": 1}))
    assert read_slots(tmp_path) == [SlotRow(STEP_NS, "moving", "r1", "r1", (0.0, 0.0)), SlotRow(STEP_NS, "moving", "r1", "r2", SLOT)]


def test_a_line_that_cannot_be_used_is_named(tmp_path: Path) -> None:
    with FormationLog(tmp_path):
        pass
    with (tmp_path / FORMATION_FILE).open("a", encoding="utf-8") as file:
        file.write("now,moving,r1,r2,0,0\n")
    with pytest.raises(RecordingError, match=r"formation\.csv:2"):
        read_slots(tmp_path)


def test_a_run_without_a_formation_has_no_slots(tmp_path: Path) -> None:
    assert read_slots(tmp_path) == []
