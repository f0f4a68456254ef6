"""The Create 2 Open Interface, with the byte sequences of its specification."""

from __future__ import annotations

import struct

import pytest

from agent.drivers.create2 import Create2
from agent.drivers.firmware import ECHO, GARBLED

QUERY = bytes([149, 6, 1, 3, 43, 44, 34, 35])
OFF, PASSIVE, SAFE, FULL = range(4)


def packets(bumps: int = 0, cliffs: bytes = b"\0\0\0\0", left: int = 0, right: int = 0, charging: int = 0, mode: int = SAFE) -> bytes:
    group_1 = bytes([bumps, 0]) + cliffs + b"\0\0\x09\0"
    group_3 = struct.pack(">BHhbHH", 0, 15000, -400, 25, 1200, 2696)
    return group_1 + group_3 + struct.pack(">2h", left, right) + bytes([charging, mode])


def test_start_and_safe_come_before_the_first_query_and_zeros_that_end_what_was_half_said_before_all() -> None:
    assert Create2().greeting() == (bytes(6) + b"\x80", b"\x83", QUERY)


def test_drive_direct_has_the_right_wheel_first_and_the_high_byte_first() -> None:
    assert Create2().command(left=-200, right=500) == bytes([145, 0x01, 0xF4, 0xFF, 0x38])


def test_unit_of_speed_is_a_millimetre_per_second_at_the_rim() -> None:
    assert Create2().traits.unit_rad_s * 0.036 == pytest.approx(0.001)
    assert Create2().traits.stops_by_itself_s is None


def test_counts_and_charge_are_read() -> None:
    sample = Create2().answer(QUERY, packets(left=-2, right=32767)).sample
    assert sample is not None
    assert sample.ticks == (-2, 32767)
    assert sample.battery == pytest.approx(1200 / 2696)
    assert (sample.trouble, sample.hazard, sample.remedy) == ("", "", b"")


@pytest.mark.parametrize(
    ("bumps", "cliffs", "hazard"),
    [
        (0b0010, b"\0\0\0\0", "bumper left"),
        (0b0001, b"\0\0\0\0", "bumper right"),
        (0b0011, b"\0\0\0\0", "bumper left, bumper right"),
        (0b1000, b"\0\0\0\0", "wheel drop left"),
        (0b0100, b"\0\0\0\0", "wheel drop right"),
        (0, b"\1\0\0\0", "cliff left"),
        (0, b"\0\1\1\0", "cliff front left, cliff front right"),
        (0, b"\0\0\0\1", "cliff right"),
    ],
)
def test_what_sensors_say_is_told_by_name(bumps: int, cliffs: bytes, hazard: str) -> None:
    sample = Create2().answer(QUERY, packets(bumps, cliffs)).sample
    assert sample is not None
    assert sample.hazard == hazard


def test_robot_that_has_left_safe_mode_is_brought_back_once_nothing_stands_against_it() -> None:
    dropped, lifted = (Create2().answer(QUERY, packets(bumps=bumps, mode=PASSIVE)).sample for bumps in (0b1000, 0))
    assert dropped is not None
    assert lifted is not None
    assert (dropped.hazard, dropped.remedy) == ("wheel drop left", b"")
    assert (lifted.hazard, lifted.remedy) == ("Create 2 stopped by itself", b"\x83")


def test_robot_in_full_mode_which_has_no_protection_is_brought_back_to_safe_mode() -> None:
    sample = Create2().answer(QUERY, packets(mode=FULL)).sample
    assert sample is not None
    assert (sample.trouble, sample.hazard, sample.remedy) == ("", "", b"\x83")


def test_no_byte_of_a_query_is_an_opcode_that_does_anything_should_its_first_byte_be_lost() -> None:
    assert all(byte not in {7, *range(128, 174)} for byte in QUERY[1:] + Create2().resync())


def test_robot_on_its_charger_is_left_there() -> None:
    sample = Create2().answer(QUERY, packets(charging=2, mode=PASSIVE)).sample
    assert sample is not None
    assert (sample.trouble, sample.hazard, sample.remedy) == ("wheels: Create 2 is on its charger", "", b"")


def test_part_of_an_answer_is_waited_for() -> None:
    assert Create2().answer(QUERY, packets()[:-1]) == (None, (), False)
    assert Create2().answer(QUERY, QUERY + packets()[:-1]) == (None, (ECHO,), False)
    assert Create2().answer(QUERY, QUERY[:-1]) == (None, (ECHO,), False)


def test_echo_is_told_from_answers() -> None:
    answer = Create2().answer(QUERY, QUERY + packets(left=7))
    assert answer.sample is not None
    assert (answer.sample.ticks, answer.refused) == ((7, 0), (ECHO,))


@pytest.mark.parametrize(
    "said",
    [packets() + b"\0", packets(bumps=16), packets(cliffs=b"\0\2\0\0"), packets(charging=4), packets(mode=OFF), packets(mode=4), b"x" * 26],
)
def test_values_that_no_packet_can_have_are_refused(said: bytes) -> None:
    assert Create2().answer(QUERY, said) == (None, (GARBLED,), True)
