"""Each local map is taken once, and every one that is not is counted."""

from __future__ import annotations

import pytest

from mapserver.intake import DUPLICATE, IMPLAUSIBLE, LATE, MAX_GAP, MAX_WAITING, OLD_EPOCH, TOO_MANY, UNKNOWN_ROBOT, Intake
from protocol.geometry import Pose2
from protocol.messages import LocalMap
from tests.unit.mapserver.worlds import STEP_NS, local_map


def acknowledged(intake: Intake) -> list[tuple[str, int, int]]:
    return [(each.robot, each.epoch, each.seq) for each in intake.acknowledgements()]


def take(intake: Intake, *local_maps: LocalMap) -> list[bool]:
    """Accept and commit one after the other."""
    taken = []
    for each in local_maps:
        taken.append(intake.accept(each))
        if taken[-1]:
            intake.commit([each])
    return taken


def test_what_is_committed_is_acknowledged() -> None:
    intake = Intake(["r1", "r2"])
    assert acknowledged(intake) == []
    take(intake, local_map("r1", 0), local_map("r1", 1))
    assert acknowledged(intake) == [("r1", 0, 1)]


def test_what_only_waits_is_not_acknowledged() -> None:
    intake = Intake(["r1"])
    take(intake, local_map("r1", 0))
    assert intake.accept(local_map("r1", 1))
    assert acknowledged(intake) == [("r1", 0, 0)]


def test_a_gap_holds_the_acknowledgement_until_it_is_filled() -> None:
    intake = Intake(["r1"])
    first, second, third = (local_map("r1", seq) for seq in range(3))
    assert [intake.accept(each) for each in (first, third, second)] == [True, True, True]
    intake.commit([first, third])
    assert acknowledged(intake) == [("r1", 0, 0)]
    intake.commit([second])
    assert acknowledged(intake) == [("r1", 0, 2)]
    assert intake.lost == {"r1": 0}


def test_lost_local_maps_are_counted_and_given_up_after_long() -> None:
    intake = Intake(["r1"])
    take(intake, local_map("r1", 0), *(local_map("r1", seq) for seq in range(3, 10)))
    assert intake.lost == {"r1": 2}
    take(intake, *(local_map("r1", seq) for seq in range(10, 4 + MAX_GAP)))
    assert intake.lost == {"r1": 2}
    assert acknowledged(intake) == [("r1", 0, 3 + MAX_GAP)]


def test_doubles_are_refused_whether_they_wait_or_are_committed() -> None:
    intake = Intake(["r1"])
    assert intake.accept(local_map("r1", 0))
    assert not intake.accept(local_map("r1", 0))
    intake.commit([local_map("r1", 0)])
    assert not intake.accept(local_map("r1", 0))
    assert not intake.accept(local_map("r1", 0, stamp_ns=9 * STEP_NS))
    assert intake.refused == {DUPLICATE: 3}
    assert intake.received == {"r1": 1}


def test_two_local_maps_of_one_stamp_are_one_too_many() -> None:
    intake = Intake(["r1"])
    assert intake.accept(local_map("r1", 0))
    assert not intake.accept(local_map("r1", 1, stamp_ns=STEP_NS))


def test_a_late_one_is_refused_but_closes_its_gap() -> None:
    intake = Intake(["r1"])
    assert take(intake, local_map("r1", 0), local_map("r1", 2), local_map("r1", 1)) == [True, True, False]
    assert intake.refused == {LATE: 1}
    assert acknowledged(intake) == [("r1", 0, 2)]


def test_a_higher_epoch_begins_anew_and_the_old_one_is_over() -> None:
    intake = Intake(["r1"])
    take(intake, local_map("r1", 0), local_map("r1", 2))
    again = local_map("r1", 0, epoch=1, stamp_ns=10 * STEP_NS)
    assert take(intake, again, local_map("r1", 3, stamp_ns=11 * STEP_NS)) == [True, False]
    assert acknowledged(intake) == [("r1", 1, 0)]
    assert intake.refused == {OLD_EPOCH: 1}
    assert intake.lost == {"r1": 1}


def test_strangers_are_refused() -> None:
    intake = Intake(["r1"])
    assert not intake.accept(local_map("r9", 0))
    assert intake.refused == {UNKNOWN_ROBOT: 1}


@pytest.mark.parametrize("field", ["motion", "odom"])
def test_motion_beyond_reason_is_refused(field: str) -> None:
    intake = Intake(["r1"])
    assert not intake.accept(local_map("r1", 0, **{field: Pose2(1e6, 0.0, 0.0)}))  # type: ignore[arg-type] # one of two of this type
    assert intake.refused == {IMPLAUSIBLE: 1}


def test_no_robot_fills_the_memory() -> None:
    intake = Intake(["r1"])
    assert all(intake.accept(local_map("r1", seq)) for seq in range(MAX_WAITING))
    assert not intake.accept(local_map("r1", MAX_WAITING))
    assert intake.refused == {TOO_MANY: 1}
