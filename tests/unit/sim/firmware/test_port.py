"""A board on a pseudo-terminal: timing, unplugging, speeds, and other devices. Time is given by the test."""

from __future__ import annotations

import select
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
import serial

from sim.firmware.create2 import Create2Rig
from sim.firmware.kinds import makers
from sim.firmware.motors import BENCH, LaggingMotors
from sim.firmware.orders import Surroundings
from sim.firmware.port import SerialPort
from sim.firmware.ros_arduino_bridge import ArduinoRig

BAUD = 57600
QUESTION, ANSWER = b"b\r", b"57600\r\n"
PATIENCE_S = 5.0


class Bench:
    """An Arduino on its port, in a time that the test lets pass."""

    def __init__(self, name: Path) -> None:
        devices = makers(ArduinoRig(boot_s=0.0), Create2Rig())
        motors = LaggingMotors(BENCH, 0.0)
        self.port = SerialPort(devices["ros_arduino_bridge"](motors, 0.0), name)
        self.surroundings = Surroundings(self.port, motors, devices)
        self.name, self.now_s = name, 0.0

    def wait(self, duration_s: float) -> None:
        """Let time pass."""
        for _ in range(20):
            self.now_s += duration_s / 20
            self.port.service(self.now_s)

    def tell(self, order: str) -> str:
        """Carry out an order."""
        return self.surroundings.carry_out(order, self.now_s)

    def send(self, client: serial.Serial, data: bytes) -> None:
        """Let a client send something, and the board begin to hear it."""
        client.write(data)
        select.select(self.port.readable, (), (), PATIENCE_S)
        self.port.service(self.now_s)

    def ask(self, client: serial.Serial, data: bytes, answer_s: float = 0.1) -> bytes:
        """Return the line that is answered to something within a time, or what has come of it by then."""
        self.send(client, data)
        self.wait(answer_s)
        return bytes(client.readline())

    @contextmanager
    def client(self, baud: int = BAUD) -> Iterator[serial.Serial]:
        """Open the port as a driver does, and let the board notice when it opens and when it closes."""
        with serial.Serial(str(self.name), baud, timeout=0.2) as client:
            self.wait(0.01)
            yield client
        self.wait(0.01)


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Bench]:
    bench = Bench(tmp_path / "motors")
    with bench.port:
        yield bench


def test_an_answer_takes_the_time_of_its_bytes_on_the_line(bench: Bench) -> None:
    with bench.client() as client:
        took_s = 10 * len(QUESTION + ANSWER) / BAUD
        bench.send(client, QUESTION)

        bench.wait(0.9 * took_s)
        early = client.read(len(ANSWER))
        bench.wait(0.2 * took_s)

        assert early == ANSWER[:-1]
        assert client.read(1) == ANSWER[-1:]


def test_an_unplugged_line_fails_its_client_and_comes_back_under_its_name(bench: Bench) -> None:
    with bench.client() as client:
        bench.tell("unplug")
        assert not bench.name.is_symlink()
        with pytest.raises(serial.SerialException):
            client.read(1)
    bench.wait(1.0)

    bench.tell("plug")

    with bench.client() as client:
        assert bench.ask(client, QUESTION) == ANSWER


def test_the_board_goes_on_while_it_is_unplugged_and_stops_by_itself(bench: Bench) -> None:
    with bench.client() as client:
        bench.ask(client, b"m 60 60\r", answer_s=1.0)
        bench.tell("unplug")
        assert float(bench.tell("wheels").split()[1]) > 3.0

        bench.wait(3.0)

        assert float(bench.tell("wheels").split()[1]) == pytest.approx(0.0, abs=1e-3)


def test_opening_the_line_restarts_an_arduino(bench: Bench) -> None:
    with bench.client() as client:
        bench.ask(client, b"m 60 60\r", answer_s=1.0)
        counted = int(bench.ask(client, b"e\r").split()[0])
    with bench.client() as client:
        assert int(bench.ask(client, b"e\r").split()[0]) < 0.5 * counted  # what the wheels ran on


def test_a_client_of_another_speed_reads_garbage_or_nothing(bench: Bench) -> None:
    with bench.client(baud=115200) as client:
        bench.send(client, 20 * QUESTION)
        bench.wait(1.0)
        assert ANSWER not in client.read(1000)


@pytest.mark.parametrize(
    ("order", "told"),
    [("lost 1", b""), ("delay 0.5", b""), ("echo on", QUESTION + ANSWER), ("garbled 0", ANSWER), ("echo off", ANSWER)],
)
def test_faults_befall_the_line_on_demand(bench: Bench, order: str, told: bytes) -> None:
    with bench.client() as client:
        assert bench.tell(order) == "ok"
        assert bench.ask(client, QUESTION) == told


def test_a_garbled_line_says_something_else(bench: Bench) -> None:
    with bench.client() as client:
        bench.tell("garbled 1")
        bench.send(client, 20 * QUESTION)
        bench.wait(1.0)
        assert ANSWER not in client.read(1000)


def test_another_device_can_be_on_the_port(bench: Bench) -> None:
    bench.tell("device gps_57600")
    with bench.client() as client:
        assert bench.ask(client, QUESTION, answer_s=0.5).startswith(b"$GPGGA")


@pytest.mark.parametrize("order", ["", "fly", "lost", "lost 2", "echo maybe", "device unicorn", "sense 7 1", "delay soon"])
def test_an_order_that_makes_no_sense_is_refused_in_one_line(bench: Bench, order: str) -> None:
    answer = bench.tell(order)
    assert answer.startswith("refused: ")
    assert "\n" not in answer
