"""A pseudo-terminal in place of a serial port, and boards at its far end that say what a script wants."""

from __future__ import annotations

import os
import pty
import re
import select
import time
import tty
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

from agent.drivers.serial_wheels import SerialWheels
from protocol.messages import WheelReadings


class Port:
    """A port that is there while it is plugged in; its file is a link, as udev makes one."""

    def __init__(self, folder: Path) -> None:
        self.path = folder / "wheels"
        self._far = self._near = -1

    def plug_in(self) -> None:
        self._far, self._near = pty.openpty()
        tty.setraw(self._near)
        os.set_blocking(self._far, False)
        self.path.unlink(missing_ok=True)
        self.path.symlink_to(os.ttyname(self._near))

    def pull(self) -> None:
        if self._far >= 0:
            os.close(self._near)
            os.close(self._far)
            self.path.unlink()
            self._far = -1

    def heard(self, at_least: int = 0, limit_s: float = 10.0) -> bytes:
        """Return what has come of what was sent, after so many bytes: a terminal hands them on in its own time, not in the sender's."""
        came = self._come()
        deadline_s = time.monotonic() + limit_s
        while len(came) < at_least:
            assert time.monotonic() < deadline_s, f"{at_least} bytes were to come, and {came!r} did"
            select.select([self._far], [], [], limit_s)
            came += self._come()
        return came

    def say(self, data: bytes) -> None:
        if self._far >= 0:
            os.write(self._far, data)

    def _come(self) -> bytes:
        with suppress(BlockingIOError):
            return os.read(self._far, 65536) if self._far >= 0 else b""
        return b""


@dataclass
class Bench:
    """A driver at a port, and at the other end a board that answers what it hears, by `reply`."""

    port: Port
    wheels: SerialWheels
    reply: Callable[[bytes], bytes]
    readings: list[WheelReadings] = field(default_factory=list)
    heard: bytes = b""

    def turn(self) -> list[WheelReadings]:
        """Let the board answer what it has heard, and the driver read once."""
        heard = self.port.heard()
        self.heard += heard
        if heard:
            self.port.say(self.reply(heard))
        taken = list(self.wheels.read(0.005))
        self.readings += taken
        return taken

    def until(self, is_so: Callable[[], bool], limit_s: float = 10.0) -> float:
        """Turn until something is so, and return how long that took [s]."""
        start_s = time.monotonic()
        while not is_so():
            assert time.monotonic() - start_s < limit_s, (self.wheels.condition, dict(self.wheels.refused), self.heard[-80:])
            self.turn()
        return time.monotonic() - start_s

    def listen_until(self, is_so: Callable[[], bool]) -> None:
        """Let the board alone go on, of whom the driver wants nothing more, until something is so."""
        while not is_so():
            self.reply(self.port.heard(at_least=1))

    def until_readings(self, count: int) -> None:
        """Turn until so many more readings have come."""
        wanted = len(self.readings) + count
        self.until(lambda: len(self.readings) >= wanted)

    @property
    def angles_rad(self) -> tuple[float, float]:
        """The angles of the last reading."""
        left, right = self.readings[-1].angles_rad.array()[-1].tolist()
        return left, right


@dataclass
class Board:
    """A board with the firmware's commands `b`, `e`, `m` and `u`, as its manual has them."""

    ticks: tuple[int, int] = (0, 0)
    speeds: tuple[int, int] = (0, 0)
    echoes: bool = False
    garble: Callable[[bytes], bytes] = lambda answer: answer  # what the line makes of an answer
    gains: bytes = b""
    _waiting: bytes = b""

    def reply(self, heard: bytes) -> bytes:
        *lines, self._waiting = (self._waiting + heard).split(b"\r")
        answers = [(line + b"\r" if self.echoes else b"") + self._answer(line) + b"\r\n" for line in lines]
        return self.garble(b"".join(answers))

    def _answer(self, line: bytes) -> bytes:
        if line == b"b":
            return b"57600"
        if line == b"e":
            return b"%d %d" % self.ticks
        if speeds := re.fullmatch(rb"m (-?\d+) (-?\d+)", line):
            self.speeds = (int(speeds[1]), int(speeds[2]))
            return b"OK"
        if line.startswith(b"u "):
            self.gains = line
            return b"OK"
        return b"Invalid Command"
