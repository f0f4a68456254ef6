"""An emulated board as a process: what a driver on its port, and orders on its stdin, get."""

from pathlib import Path

import serial

from tests.emulated_board import emulated_board


def test_a_board_answers_on_its_port_and_obeys_orders(tmp_path: Path) -> None:
    with emulated_board("create2", tmp_path / "motors") as board, serial.Serial(str(board.port), 115200, timeout=5.0) as client:
        client.write(bytes((128, 131, 145, 0, 100, 0, 100, 142, 35)))  # start, safe, drive direct, mode
        assert client.read(1) == b"\x02"
        board.tell("sense 7 8")  # the left wheel drops
        client.write(bytes((142, 7, 142, 35)))
        assert client.read(2) == b"\x08\x01"
        assert board.wheels().left_rad_s < 100e-3 / 0.036


def test_its_name_is_gone_with_it(tmp_path: Path) -> None:
    with emulated_board("ros_arduino_bridge", tmp_path / "motors") as board:
        assert board.port.is_symlink()
    assert not board.port.is_symlink()
