"""What can go wrong while a real agent drives: it is refused, counted and told, and the wheels stand."""

from __future__ import annotations

import math
import os
import signal
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from agent.control.setpoints import DUPLICATE, EXPIRED, OLD_EPOCH, OUT_OF_ORDER, TOO_FAR, TOO_FAST
from agent.vision.liveness import DARK, FROZEN
from protocol.messages import Setpoint, Setpoints
from tests.loopback.agent_files import HEIGHT_PX, WIDTH_PX
from tests.loopback.drive_bench import HALF_SECOND_NS, DriveBench, open_bench

LIMIT_S = 0.5  # in which wheels have to stand
SECOND_GUARD_S = 10.0  # to load Python anew

pytestmark = pytest.mark.slow


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[DriveBench]:
    with open_bench(tmp_path) as bench:
        bench.start()
        yield bench


def test_a_robot_without_setpoint_stands_and_answers(bench: DriveBench) -> None:
    bench.drive(5)
    bench.step()
    bench.locate()
    bench.broadcast([bench.straight_on(robot="r2")])
    assert bench.answer().stands
    assert bench.report().state == "no setpoint for this robot: standing"


def test_a_robot_that_knows_no_pose_answers_with_standing_wheels(bench: DriveBench) -> None:
    bench.step()
    bench.broadcast()
    assert bench.answer().stands


def test_the_same_drive_gives_the_same_commands(bench: DriveBench, tmp_path_factory: pytest.TempPathFactory) -> None:
    first = [answer.command for answer in bench.drive(12)]
    with open_bench(tmp_path_factory.mktemp("again")) as again:
        again.start()
        assert [answer.command for answer in again.drive(12)] == first


def test_an_answer_comes_soon(bench: DriveBench) -> None:
    bench.drive(3)
    delays_s = []
    for _ in range(20):
        bench.step()
        bench.locate()
        sent_s = time.monotonic()
        bench.broadcast()
        delays_s.append(bench.answer().arrived_s - sent_s)
    assert np.median(delays_s) < 0.05


def test_wheels_stand_when_the_agent_is_interrupted_in_mid_drive(bench: DriveBench) -> None:
    bench.drive(5)
    assert bench.agent is not None
    bench.agent.send_signal(signal.SIGINT)
    assert bench.stands_within(LIMIT_S) < LIMIT_S
    assert bench.agent.wait(5.0) == 0


def test_wheels_stand_when_the_wheel_guard_itself_is_killed_in_mid_drive(bench: DriveBench) -> None:
    bench.drive(5)
    os.kill(bench.guard_pid(), signal.SIGKILL)
    bench.stands_within(SECOND_GUARD_S)
    assert bench.agent is not None
    assert bench.agent.wait(SECOND_GUARD_S) == 2


def test_wheels_stand_when_the_helm_is_killed_in_mid_drive(bench: DriveBench) -> None:
    bench.drive(5)
    os.kill(bench.helm_pid(), signal.SIGKILL)
    assert bench.stands_within(LIMIT_S) < LIMIT_S
    assert bench.agent is not None
    assert bench.agent.wait(5.0) == 2


def test_wheels_stand_when_the_map_server_falls_silent(bench: DriveBench) -> None:
    bench.drive(5)
    assert bench.stands_within(LIMIT_S + 0.1) < LIMIT_S
    assert bench.report().state.startswith("no setpoints for ")
    assert not bench.drive(3)[-1].stands


def test_the_same_setpoints_again_keep_the_wheels_turning(bench: DriveBench) -> None:
    bench.drive(5)
    command, start_s = bench.heard[-1].command, bench.heard[-1].arrived_s
    while bench.heard[-1].arrived_s < start_s + 0.8:
        bench.broadcast()
        bench.next_command()
    assert all(heard.command == command for heard in bench.heard if heard.arrived_s >= start_s)


def test_a_restarted_map_server_goes_on_with_a_higher_epoch_and_an_older_one_is_refused(bench: DriveBench) -> None:
    bench.drive(5)
    bench.epoch, bench.seq = 2, 0
    assert not bench.drive(3)[-1].stands
    bench.broadcast(epoch=1, seq=500)
    bench.drive(1)
    assert bench.report().reasons == {OLD_EPOCH: 1}


def test_setpoints_in_disorder_are_refused_and_counted(bench: DriveBench) -> None:
    bench.drive(5)
    count = len(bench.heard)
    last = bench.broadcast()
    bench.setpoints.put(last)
    bench.setpoints.put(last.model_copy(update={"seq": last.seq - 2, "robots": ()}))
    bench.until(lambda: bench.report().reasons == {DUPLICATE: 1, OUT_OF_ORDER: 1})
    assert not any(heard.stands for heard in bench.heard[count:])


@pytest.mark.parametrize(
    ("reason", "ahead_m", "speed_m_s"), [(TOO_FAST, 0.05, 0.6), (TOO_FAST, 0.05, -1e300), (TOO_FAR, 2.5, 0.1), (TOO_FAR, 1e200, 0.1)]
)
def test_setpoints_out_of_limits_are_refused_counted_and_answered_with_standing_wheels(
    bench: DriveBench, reason: str, ahead_m: float, speed_m_s: float
) -> None:
    bench.drive(5)
    bench.step()
    bench.locate()
    bench.broadcast([bench.straight_on(ahead_m, speed_m_s)])
    assert bench.answer().stands
    assert bench.report().reasons == {reason: 1}


def test_setpoints_that_come_too_late_are_refused_counted_and_answered_with_standing_wheels(bench: DriveBench) -> None:
    bench.drive(5)
    bench.step()
    bench.locate()
    bench.broadcast(valid_until_ns=bench.stamp_ns - 1)
    assert bench.answer().stands
    assert bench.report().reasons == {EXPIRED: 1}


@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_setpoints_with_numbers_that_are_none_are_refused_and_counted(bench: DriveBench, value: float) -> None:
    bench.drive(5)
    count = len(bench.heard)
    spoilt = Setpoint.model_construct(robot="r1", arena_from_body=(0.0, value, 0.0), speed_m_s=0.1, turn_rad_s=0.0)
    until_ns = bench.stamp_ns + HALF_SECOND_NS
    bench.setpoints.put(
        Setpoints.model_construct(epoch=1, seq=bench.seq, stamp_ns=bench.stamp_ns, valid_until_ns=until_ns, robots=(spoilt,))
    )
    bench.until(lambda: bench.report().reasons == {"invalid: robots": 1})
    assert bench.stands_within(LIMIT_S + 0.1) < LIMIT_S
    assert all(math.isfinite(heard.command.left_rad_s) for heard in bench.heard[count:])


def test_a_robot_whose_camera_falls_silent_stands_and_says_why(bench: DriveBench) -> None:
    bench.drive(5)
    for _ in range(6):
        bench.step(with_frame=False)
        bench.locate()
        bench.broadcast()
        bench.answer()
    assert bench.answer().stands
    assert bench.report().state == "no usable picture for 0.6 s: standing"
    assert not bench.drive(3)[-1].stands


@pytest.mark.parametrize(("fault", "level"), [(FROZEN, 120), (DARK, 0)])
def test_a_robot_whose_camera_freezes_or_goes_dark_stands_and_says_why(bench: DriveBench, fault: str, level: int) -> None:
    bench.drive(5)
    bench.shown = np.full((HEIGHT_PX, WIDTH_PX, 3), level, dtype=np.uint8)
    bench.shown[::7, ::5] += 2
    assert bench.drive(12)[-1].stands
    report = bench.report()
    assert report.state.startswith("no usable picture for ")
    assert report.reasons[fault] >= 5
    bench.shown = None
    assert not bench.drive(3)[-1].stands
