"""A serial line: bytes take their time, and get lost or garbled where that is asked for."""

import pytest

from sim.firmware.line import Line, LineFaults

BAUD = 57600


def test_ten_bits_a_byte_arrive_one_after_the_other() -> None:
    line = Line(LineFaults())
    line.put(b"ab", 1.0, BAUD)
    line.put(b"c", 1.0, BAUD)

    assert line.take(1.0) == []
    assert line.due_s == pytest.approx(1.0 + 10 / BAUD)
    assert [(chr(byte), round((at_s - 1.0) * BAUD)) for byte, at_s in line.take(2.0)] == [("a", 10), ("b", 20), ("c", 30)]


def test_lost_bytes_never_arrive_and_garbled_ones_arrive_as_others() -> None:
    faults = LineFaults(lost_share=0.1)
    line = Line(faults)
    line.put(bytes(1000), 0.0, BAUD)
    assert 850 < len(line.take(10.0)) < 950

    faults.lost_share, faults.garbled_share = 0.0, 0.1
    line.put(bytes(1000), 10.0, BAUD)
    arrived = line.take(20.0)
    assert len(arrived) == 1000
    assert 50 < sum(arrival.byte != 0 for arrival in arrived) < 150


def test_a_cut_line_loses_what_is_on_its_way() -> None:
    line = Line(LineFaults())
    line.put(b"abc", 0.0, BAUD)
    line.cut()
    assert line.take(1.0) == []
