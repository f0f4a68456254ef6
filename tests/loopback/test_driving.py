"""Driving with real agent processes: every setpoint is answered, and whatever goes wrong, the wheels stand."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from tests.loopback.drive_bench import DriveBench, Heard, open_bench

LIMIT_S = 0.5  # in which wheels have to stand


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[DriveBench]:
    with open_bench(tmp_path) as bench:
        bench.start()
        yield bench


@contextmanager
def frozen(pid: int) -> Iterator[None]:
    """Have a process stand still meanwhile."""
    os.kill(pid, signal.SIGSTOP)
    try:
        yield
    finally:
        os.kill(pid, signal.SIGCONT)


def drive_blindly(bench: DriveBench, steps: int) -> list[Heard]:
    """Drive straight on for some steps without a picture, and return the answers."""
    answers = []
    for _ in range(steps):
        bench.step(with_frame=False)
        bench.locate()
        bench.broadcast()
        answers.append(bench.answer())
    return answers


def test_a_robot_follows_its_setpoints_and_answers_each(bench: DriveBench) -> None:
    answers = bench.drive(15)
    assert not any(answer.stands for answer in answers)
    assert bench.pose.x_m > 0.12
    assert abs(bench.pose.y_m) < 0.01
    report = bench.report()
    assert (report.drive, report.state, report.reasons) == ("driving", "mapping", {})


def test_wheels_stand_when_the_agent_is_killed_in_mid_drive(bench: DriveBench) -> None:
    bench.drive(5)
    assert bench.agent is not None
    bench.agent.kill()
    assert bench.stands_within(LIMIT_S) < LIMIT_S


def test_setpoints_are_answered_while_the_agent_is_at_work_on_a_picture(bench: DriveBench) -> None:
    bench.drive(5)
    with frozen(bench.agent_pid()):  # a picture that never ends
        answers = drive_blindly(bench, 4)
    assert not any(answer.stands for answer in answers)


def test_a_robot_whose_agent_is_frozen_stands_when_its_last_picture_is_old_and_may_go_on(bench: DriveBench) -> None:
    bench.drive(5)
    with frozen(bench.agent_pid()):
        assert drive_blindly(bench, 6)[-1].stands
    assert not bench.drive(3)[-1].stands


def test_wheels_stand_when_the_helm_is_frozen_in_mid_drive_and_it_may_go_on(bench: DriveBench) -> None:
    bench.drive(5)
    with frozen(bench.helm_pid()):
        bench.broadcast()
        assert bench.stands_within(LIMIT_S) < LIMIT_S
    assert not bench.drive(3)[-1].stands


def test_a_latched_stop_holds_until_it_is_released(bench: DriveBench) -> None:
    bench.drive(5)
    state = bench.order("stop", "a cat")
    assert (state.who, state.stopped, state.reason) == ("r1", True, "a cat")
    assert bench.heard[-1].stands
    assert all(answer.stands for answer in bench.drive(3))
    report = bench.report()
    assert (report.drive, report.state) == ("stopped", "stopped: a cat")
    assert bench.order("question").stopped
    assert not bench.order("release").stopped
    assert not bench.drive(3)[-1].stands
