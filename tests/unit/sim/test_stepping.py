"""When the world goes on: whom it waits for, and for how long."""

from __future__ import annotations

import pytest

from protocol.messages import WheelCommand
from sim.real_time import RealTime
from sim.stepping import PATIENCE_S, Lockstep, RealStepping

T_NS = 1_000_000_000
ALL = frozenset({"r1", "r2"})


def command(answers_ns: int = T_NS) -> WheelCommand:
    return WheelCommand(left_rad_s=1.0, right_rad_s=1.0, answers_ns=answers_ns)


@pytest.fixture
def lockstep() -> Lockstep:
    """Return one that has shown a moment to both robots, at 0 s."""
    stepping = Lockstep()
    stepping.shown(T_NS, ALL, 0.0)
    return stepping


def test_lockstep_waits_for_the_answer_of_every_robot(lockstep: Lockstep) -> None:
    assert not lockstep.may_go_on(ALL, 0.1)
    assert lockstep.arrived("r1", command(), 0.1) == T_NS
    assert not lockstep.may_go_on(ALL, 0.1)
    lockstep.arrived("r2", command(), 0.2)
    assert lockstep.may_go_on(ALL, 0.2)


def test_an_answer_to_an_earlier_moment_does_not_count(lockstep: Lockstep) -> None:
    for answers_ns in (0, T_NS - 1):
        lockstep.arrived("r1", command(answers_ns), 0.1)
        lockstep.arrived("r2", command(answers_ns), 0.1)
    assert not lockstep.may_go_on(ALL, 0.1)


def test_a_stop_after_the_answer_does_not_take_it_back(lockstep: Lockstep) -> None:
    for robot in ALL:
        lockstep.arrived(robot, command(), 0.1)
        lockstep.arrived(robot, command(0), 0.2)
    assert lockstep.may_go_on(ALL, 0.2)


def test_nobody_waits_for_a_robot_that_is_gone(lockstep: Lockstep) -> None:
    lockstep.arrived("r1", command(), 0.1)
    assert lockstep.may_go_on(frozenset({"r1"}), 0.1)


def test_a_robot_that_comes_back_owes_nothing_before_the_next_moment(lockstep: Lockstep) -> None:
    lockstep.arrived("r1", command(), 0.1)
    lockstep.may_go_on(frozenset({"r1"}), 0.1)
    assert lockstep.may_go_on(ALL, 0.2)
    lockstep.shown(T_NS + 1, ALL, 0.3)
    assert not lockstep.may_go_on(ALL, 0.3)


def test_a_robot_that_never_answers_is_given_up_for_the_step_and_named_once(lockstep: Lockstep, caplog: pytest.LogCaptureFixture) -> None:
    lockstep.arrived("r1", command(), 0.1)
    assert not lockstep.may_go_on(ALL, PATIENCE_S - 0.1)
    assert lockstep.may_go_on(ALL, PATIENCE_S)
    lockstep.shown(2 * T_NS, frozenset({"r2"}), 20.0)
    assert not lockstep.may_go_on(ALL, 20.1)
    assert lockstep.may_go_on(ALL, 20.0 + PATIENCE_S)
    assert lockstep.given_up == {"r2": 2}
    assert len(caplog.messages) == 1
    assert caplog.messages[0].startswith("r2 has not answered for 10 s")


def test_before_anything_was_shown_nobody_owes_anything() -> None:
    assert Lockstep().may_go_on(ALL, 0.0)


def test_in_real_time_nobody_is_waited_for_and_commands_count_when_they_come() -> None:
    pace = RealTime(1.0, lambda: 50.0)
    stepping = RealStepping(pace)
    pace.began(T_NS)
    stepping.shown(T_NS, ALL, 50.02)
    assert stepping.may_go_on(ALL, 50.02)
    assert stepping.arrived("r1", command(), 50.03) == pytest.approx(T_NS + 30_000_000, abs=10)
    assert stepping.arrived("r1", command(), 49.0) == T_NS
