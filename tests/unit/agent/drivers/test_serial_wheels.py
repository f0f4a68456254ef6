"""Wheels behind a serial line, with everything that such a line does."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path

import pytest

from agent.drivers.polling import MISSING, SLOW
from agent.drivers.ros_arduino_bridge import NOT_UNDERSTOOD, RosArduinoBridge
from agent.drivers.serial_wheels import CLOCK_UNKNOWN, JUMPED, SerialWheels
from tests.unit.agent.drivers.port import Bench, Board, Port

TICKS = 1920.0
UNIT_RAD_S = math.tau / (TICKS * 0.033)


def as_it_is(monotonic_ns: int) -> int | None:
    return monotonic_ns


@pytest.fixture
def board() -> Board:
    return Board()


@pytest.fixture
def port(tmp_path: Path) -> Iterator[Port]:
    port = Port(tmp_path)
    port.plug_in()
    yield port
    port.pull()


@contextmanager
def wheels_at(port: Port, stamp_ns: Callable[[int], int | None] = as_it_is) -> Iterator[SerialWheels]:
    firmware = RosArduinoBridge(TICKS, 30, 57600, None, settle_s=0.0)
    with closing(SerialWheels(str(port.path), 57600, firmware, 12.0, stamp_ns)) as wheels:
        yield wheels


@pytest.fixture
def bench(port: Port, board: Board) -> Iterator[Bench]:
    with wheels_at(port) as wheels:
        yield Bench(port, wheels, board.reply)


def test_wheels_are_told_to_stop_before_anything_else(bench: Bench) -> None:
    assert bench.wheels.condition.trouble == f"wheels: {bench.port.path} is not open yet"
    bench.until_readings(1)
    assert bench.heard.startswith(b"m 0 0\r")
    assert bench.wheels.condition.trouble == ""


def test_encoders_are_read_as_angles_with_the_moment_between_question_and_answer(bench: Bench, board: Board) -> None:
    bench.until_readings(1)
    board.ticks = (19, -19)
    before_ns = time.monotonic_ns()
    bench.until_readings(2)
    assert bench.angles_rad == pytest.approx((19 * math.tau / TICKS, -19 * math.tau / TICKS))
    assert before_ns < bench.readings[-1].until_ns < time.monotonic_ns()
    assert bench.readings[-1].stamps_ns.array()[-1] == bench.readings[-1].until_ns


def test_speeds_are_rounded_to_ticks_and_what_was_applied_is_returned(bench: Bench, board: Board) -> None:
    bench.until_readings(1)
    applied = bench.wheels.drive(10.2 * UNIT_RAD_S, -3.8 * UNIT_RAD_S, answers_ns=7)
    assert (applied.left_rad_s, applied.right_rad_s) == pytest.approx((10 * UNIT_RAD_S, -4 * UNIT_RAD_S))
    assert applied.answers_ns == 7
    bench.until(lambda: board.speeds == (10, -4))


def test_speeds_beyond_the_limit_are_slowed_by_one_factor(bench: Bench) -> None:
    bench.until_readings(1)
    applied = bench.wheels.drive(24.0, 12.0)
    assert (applied.left_rad_s, applied.right_rad_s) == pytest.approx((12.0, 6.0), abs=UNIT_RAD_S)


def test_a_command_that_was_lost_on_the_line_is_repeated_with_the_next_request(bench: Bench, board: Board) -> None:
    bench.until_readings(1)
    bench.wheels.drive(1.0, 1.0)
    bench.until(lambda: board.speeds == (10, 10))
    board.speeds = (0, 0)
    bench.until(lambda: board.speeds == (10, 10))


def test_stop_goes_out_at_once(bench: Bench, board: Board) -> None:
    bench.until_readings(1)
    bench.wheels.drive(1.0, 1.0)
    bench.until(lambda: board.speeds == (10, 10))
    bench.wheels.stop()
    bench.listen_until(lambda: board.speeds == (0, 0))
    assert board.speeds == (0, 0)


def test_readings_without_a_known_clock_are_not_handed_out(port: Port, board: Board) -> None:
    with wheels_at(port, lambda _: None) as wheels:
        bench = Bench(port, wheels, board.reply)
        bench.until(lambda: wheels.refused.get(CLOCK_UNKNOWN, 0) > 2)
        assert bench.readings == []


def test_pulled_line_is_told_at_once_and_no_speed_is_taken_until_it_is_back(bench: Bench, board: Board) -> None:
    bench.until_readings(1)
    bench.wheels.drive(1.0, 1.0)
    board.ticks = (30, 30)
    bench.until_readings(2)
    angles_rad = bench.angles_rad
    bench.port.pull()
    assert bench.until(lambda: bool(bench.wheels.condition.trouble)) < 0.2
    assert bench.wheels.condition.trouble == f"wheels: {bench.port.path} is gone; trying again"
    assert bench.wheels.drive(1.0, 1.0).left_rad_s == 0.0
    board.ticks, board.speeds = (0, 0), (0, 0)  # opening a port restarts most boards
    bench.port.plug_in()
    bench.until_readings(3)
    assert bench.angles_rad == pytest.approx(angles_rad)
    assert bench.wheels.condition.trouble == ""
    assert board.speeds == (0, 0)
    assert bench.wheels.refused["line: is gone"] == 1


def test_port_that_is_not_there_is_looked_for_less_and_less_often(bench: Bench) -> None:
    bench.port.pull()
    bench.until(lambda: "is not there" in bench.wheels.condition.trouble)
    bench.port.plug_in()
    bench.until_readings(1)


def test_port_that_another_program_holds_is_told(bench: Bench) -> None:
    bench.until_readings(1)
    with wheels_at(bench.port) as second:
        second.read(0.0)
        assert "is held by another program" in second.condition.trouble


def test_lost_bytes_cost_single_readings(bench: Bench, board: Board) -> None:
    bench.until_readings(1)
    board.garble = lambda answer: answer[:-3]
    bench.until(lambda: bench.wheels.refused.get(MISSING, 0) == 1)
    board.garble = lambda answer: answer
    bench.until_readings(3)
    assert bench.wheels.condition.trouble == ""


def test_command_that_was_not_understood_is_counted(bench: Bench, board: Board) -> None:
    bench.until_readings(1)
    bench.port.say(b"Invalid Command\r\nInvalid Command\r\n")
    bench.until_readings(3)
    board.garble = lambda answer: answer.replace(b"OK", b"Invalid Command")
    bench.until(lambda: bench.wheels.refused.get(NOT_UNDERSTOOD, 0) > 0)


def test_echo_does_no_harm_and_is_counted(bench: Bench, board: Board) -> None:
    board.echoes = True
    bench.until_readings(5)
    assert bench.wheels.refused["answer: echo of what was sent"] >= 5


def test_board_that_restarts_does_not_make_the_angles_jump(bench: Bench, board: Board) -> None:
    board.ticks = (100_000, 100_000)
    bench.until_readings(2)
    board.ticks = (0, 0)
    bench.until_readings(2)
    assert bench.angles_rad == pytest.approx((0.0, 0.0))
    assert bench.wheels.refused[JUMPED] == 1


def test_garbage_alone_loses_the_line_and_the_wheels_are_stopped(bench: Bench, board: Board) -> None:
    bench.until_readings(1)
    bench.wheels.drive(1.0, 1.0)
    board.garble = lambda answer: b"\xfe" * len(answer)
    bench.until(lambda: "gives no good answers any more" in bench.wheels.condition.trouble)
    bench.listen_until(lambda: board.speeds == (0, 0))
    assert board.speeds == (0, 0)


@pytest.mark.parametrize(
    ("says", "told"),
    [
        (b"", "does not answer as ROSArduinoBridge"),
        (b"$GPGGA,115713.000\r\n", "answers, but not as ROSArduinoBridge: b'$GPGGA"),
        (b"115200\r\n", "answers, but not as ROSArduinoBridge: b'115200"),
    ],
)
def test_other_device_at_the_port_is_told_and_never_driven(bench: Bench, says: bytes, told: str) -> None:
    bench.reply = lambda _: says
    bench.until(lambda: told in bench.wheels.condition.trouble)
    bench.wheels.drive(1.0, 1.0)
    assert b"m 10" not in bench.heard + bench.port.heard()


def test_line_that_only_echoes_is_told(bench: Bench) -> None:
    bench.reply = lambda heard: heard
    bench.until(lambda: "only echoes what is sent" in bench.wheels.condition.trouble)


def test_slow_answers_are_refused_since_nobody_knows_their_moment(bench: Bench, board: Board) -> None:
    bench.until_readings(1)
    waiting: list[tuple[float, bytes]] = []

    def later(heard: bytes) -> bytes:
        waiting.append((time.monotonic() + 0.07, board.reply(heard)))
        return b""

    bench.reply = later
    before = len(bench.readings)
    while not bench.wheels.condition.trouble:
        bench.turn()
        while waiting and waiting[0][0] <= time.monotonic():
            bench.port.say(waiting.pop(0)[1])
    assert len(bench.readings) == before
    assert bench.wheels.refused[SLOW] > 0
