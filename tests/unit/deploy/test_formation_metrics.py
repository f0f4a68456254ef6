"""The formation's score: followers against their slots, laid at the true leader."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from deploy.evaluation.formation_metrics import SlotRow, read_slots, score_formation
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


def test_the_time_to_open_again_counts_from_where_the_formation_is_narrowest() -> None:
    slots = [(-0.4, 0.2), (-0.4, 0.1), (-0.4, 0.0), (-0.4, 0.1), (-0.4, 0.2)]
    truth = {"r1": still(0.0, 0.0, 0.0, 5), "r2": still(-0.4, 0.2, 0.0, 5)}
    score = score_formation(rows(["moving", "avoiding", "avoiding", "avoiding", "moving"], slots), truth)
    assert score is not None
    assert score.restored_s == pytest.approx((0.2,))


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
