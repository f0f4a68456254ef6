"""What a motor controller board is to its serial line, and what motors are to a board."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from sim.world.drive import Turning, Wheels


class Motors(Protocol):
    """A pair of driven wheels. Times are on any monotonic clock [s], and never go back."""

    def command(self, speeds_rad_s: Wheels, now_s: float) -> None:
        """Turn both wheels at these speeds from now on."""
        ...

    def turning(self, now_s: float) -> Turning:
        """Return how the wheels turn now."""
        ...


class Board(Protocol):
    """A firmware as a machine: bytes in, bytes out, time given. Times are on any monotonic clock [s], and never go back."""

    @property
    def baud(self) -> int:
        """The speed of its serial line, at ten bits a byte [bit/s]."""
        ...

    def opened(self, now_s: float) -> None:
        """Take note that somebody opens the serial line, by which some boards are reset."""
        ...

    def reboot(self, now_s: float) -> None:
        """Lose power for a moment."""
        ...

    def receive(self, byte: int, now_s: float) -> bytes:
        """Take a byte that has arrived and return the answer to it, if it has one."""
        ...

    def turn(self, now_s: float) -> bytes:
        """Do what the firmware does by itself until now, and return what it says unasked."""
        ...

    def sense(self, sensor: int, value: int) -> None:
        """Let a sensor, numbered as its firmware numbers it, read a value from now on; raises ValueError where it cannot."""
        ...


Maker = Callable[[Motors, float], Board]  # of a board, with its motors, that is switched on at a time [s]
