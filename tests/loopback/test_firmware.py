"""An emulated board as a process: what a driver on its port, and orders on its stdin, get."""

import math
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import serial

from protocol.bus import Bus
from protocol.fields import Packed
from protocol.messages import WheelReadings
from protocol.topics import WHEEL_COMMAND, WHEEL_READINGS, WHEELS_READY
from tests.emulated_board import emulated_board

PATIENCE_S = 20.0


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


@pytest.fixture
def world() -> Iterator[Bus]:
    with Bus.open_router("lab") as world:
        yield world


def test_in_a_world_its_motors_turn_the_worlds_and_its_encoders_count_what_turned_there(world: Bus, tmp_path: Path) -> None:
    commands, ready = world.inbox(WHEEL_COMMAND, robot="r1"), world.presence(WHEELS_READY)
    readings = world.publisher(WHEEL_READINGS, robot="r1")
    where = ("--world", world.endpoint, "--site", "lab", "--scenario", "empty", "--robot", "r1")
    with emulated_board("create2", tmp_path / "motors", *where) as board, serial.Serial(str(board.port), 115200, timeout=5.0) as client:
        ready.wait_for(["r1"], PATIENCE_S)

        client.write(bytes((128, 131, 145, 0, 108, 0, 72)))  # start, safe, drive direct: 108 mm/s right, 72 mm/s left
        while not (heard := commands.take()):
            world.wait(PATIENCE_S)
        assert (heard[0].left_rad_s, heard[0].right_rad_s) == pytest.approx((2.0, 3.0))

        client.write(bytes((145, 0, 0, 0, 0)))
        for _ in range(40):  # what it reckons is drawn to what it is told
            now_ns = time.time_ns()
            readings.put(WheelReadings(until_ns=now_ns, stamps_ns=Packed.of([now_ns], "i8"), angles_rad=Packed.of([[10.0, 20.0]], "f8")))
        deadline_s = time.monotonic() + PATIENCE_S
        while board.wheels()[2:] != pytest.approx((10.0, 20.0), abs=0.01):
            assert time.monotonic() < deadline_s
        client.write(bytes((149, 2, 43, 44)))
        left, right = np.frombuffer(client.read(4), dtype=">i2")
        assert left == pytest.approx(10.0 * 508.8 / (2.0 * math.pi), abs=2)
        assert right == pytest.approx(20.0 * 508.8 / (2.0 * math.pi), abs=2)


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (("--port", "/nowhere/motors"), "/nowhere/motors: cannot be made a serial port"),
        (("--port", "motors", "--robot", "r1"), "need --world, --scenario and --robot"),
        (("--port", "motors", "--world", "tcp/127.0.0.1:1", "--scenario", "empty", "--robot", "r9"), "empty: there is no robot r9"),
    ],
)
def test_what_it_cannot_use_is_named_in_one_line(arguments: tuple[str, ...], complaint: str, tmp_path: Path) -> None:
    command = [sys.executable, "-m", "sim.firmware", "create2", *arguments]
    ended = subprocess.run(command, capture_output=True, text=True, stdin=subprocess.DEVNULL, timeout=30.0)
    assert ended.returncode == 2
    assert complaint in ended.stderr.splitlines()[-1]
    assert "Traceback" not in ended.stderr
