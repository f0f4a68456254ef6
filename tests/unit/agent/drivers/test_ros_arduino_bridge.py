"""The text protocol of the ROSArduinoBridge firmware."""

from __future__ import annotations

import math

import pytest

from agent.drivers.firmware import ECHO, GARBLED
from agent.drivers.ros_arduino_bridge import NOT_UNDERSTOOD, RosArduinoBridge


def board(pid: tuple[int, int, int, int] | None = None) -> RosArduinoBridge:
    return RosArduinoBridge(ticks_per_revolution=1920.0, pid_rate_hz=30, baud=57600, pid=pid, settle_s=0.0)


SENT = b"m 10 -10\re\r"


def test_speeds_are_ticks_per_pid_interval_which_has_whole_milliseconds() -> None:
    assert board().traits.unit_rad_s * 0.033 == pytest.approx(math.tau / 1920.0)  # 1000 / 30 = 33 ms, as the board divides
    assert board().command(10, -10) == b"m 10 -10\r"


@pytest.mark.parametrize("said", [b"57600\r\n", b" 57600\r\n", b"Invalid Command\r\n57600\r\n", b"b\r57600\r\n"])
def test_board_is_known_by_its_baud_rate(said: bytes) -> None:
    assert board().recognises(b"b\r", said)


@pytest.mark.parametrize("said", [b"", b"57600", b"115200\r\n", b"b\r", b"$GPGGA,57600,\r\n", b"\x00\xff\x80"])
def test_whoever_does_not_say_it_is_somebody_else(said: bytes) -> None:
    assert not board().recognises(b"b\r", said)


def test_gains_are_set_before_the_board_is_asked_who_it_is() -> None:
    assert board().greeting() == (b"\r", b"b\r")
    assert board((20, 12, 0, 50)).greeting() == (b"\r", b"u 20:12:0:50\r", b"b\r")


def test_counts_are_read_behind_the_command_s_acknowledgement() -> None:
    answer = board().answer(SENT, b"OK\r\n-123 2147483647\r\n")
    assert answer.sample is not None
    assert (answer.sample.ticks, answer.refused) == ((-123, 2147483647), ())


@pytest.mark.parametrize("said", [b"", b"OK\r\n", b"OK\r\n12 1", b"OK\r\n12 13"])
def test_part_of_an_answer_is_waited_for(said: bytes) -> None:
    assert board().answer(SENT, said) == (None, (), False)


def test_echo_is_told_from_answers() -> None:
    answer = board().answer(SENT, b"m 10 -10\rOK\r\ne\r12 13\r\n")
    assert answer.sample is not None
    assert (answer.sample.ticks, set(answer.refused)) == ((12, 13), {ECHO})


@pytest.mark.parametrize(
    ("said", "reason"), [(b"OK\r\n1213\r\n", GARBLED), (b"OK\r\n\xff2 1\x80\r\n", GARBLED), (b"OK\r\nInvalid Command\r\n", NOT_UNDERSTOOD)]
)
def test_answer_that_cannot_be_read_is_not_waited_for_any_longer(said: bytes, reason: str) -> None:
    assert board().answer(SENT, said) == (None, (reason,), True)
