"""How soon setpoints were answered, from what was heard and when."""

from __future__ import annotations

import pytest

from protocol.inbox import Arrived
from protocol.messages import Setpoint, Setpoints, WheelCommand
from tests.bench.answers import SETTLING_NS, answers

STAMP_NS = 10 * SETTLING_NS


def said(arrived_s: float, *robots: str, stamp_ns: int = STAMP_NS, seq: int = 0) -> Arrived[Setpoints]:
    setpoints = tuple(Setpoint(robot=robot, arena_from_body=(0.0, 0.0, 0.0), speed_m_s=0.0, turn_rad_s=0.0) for robot in robots)
    return Arrived(Setpoints(epoch=1, seq=seq, stamp_ns=stamp_ns, valid_until_ns=stamp_ns, robots=setpoints), arrived_s, 0)


def done(arrived_s: float, answers_ns: int = STAMP_NS) -> Arrived[WheelCommand]:
    return Arrived(WheelCommand(left_rad_s=1.0, right_rad_s=1.0, answers_ns=answers_ns), arrived_s, 0)


def test_every_robot_s_first_command_for_a_stamp_counts() -> None:
    found = answers([said(5.0, "r1", "r2")], {"r1": [done(5.02), done(5.09)], "r2": [done(5.03)]})
    assert found.delays_ms == pytest.approx([20.0, 30.0])
    assert found.unanswered == 0


def test_a_repeated_broadcast_is_answered_from_its_first_time_on() -> None:
    assert answers([said(5.0, "r1"), said(5.1, "r1", seq=1)], {"r1": [done(5.12)]}).delays_ms == pytest.approx([120.0])


def test_a_robot_without_a_setpoint_owes_no_answer_and_a_stop_is_none() -> None:
    found = answers([said(5.0, "r1")], {"r1": [done(5.01, answers_ns=0), done(5.02)], "r2": [done(5.5)]})
    assert found.delays_ms == pytest.approx([20.0])


def test_what_is_never_answered_is_counted_but_for_what_may_still_be_on_its_way() -> None:
    late = said(6.0, "r1", stamp_ns=STAMP_NS + SETTLING_NS, seq=1)
    later = said(6.1, "r1", stamp_ns=STAMP_NS + SETTLING_NS + 1, seq=2)
    found = answers([said(5.0, "r1"), late, later], {"r1": []})
    assert found.unanswered == 1
    assert not found.delays_ms


def test_an_answer_that_is_heard_before_its_setpoints_took_no_time() -> None:
    assert answers([said(5.0, "r1")], {"r1": [done(4.999)]}).delays_ms == (0.0,)
