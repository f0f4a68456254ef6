"""What a motor controller on a serial line speaks: bytes out, bytes in, and no input or output of its own."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, Protocol

ECHO = "answer: echo of what was sent"
GARBLED = "answer: garbled"


@dataclass(frozen=True)
class Traits:
    """What never changes about a motor controller."""

    name: str  # for a person
    ticks_per_revolution: float  # of a wheel
    counter_bits: int  # at which the encoder counts, which are signed, wrap
    unit_rad_s: float  # commands are whole multiples of this wheel speed
    max_units: int  # the fastest command to a wheel
    stops_by_itself_s: float | None  # after so long without a command; None: never
    acknowledgement: bytes = b""  # what it says to a command
    settle_s: float = 0.0  # after the port was opened, before it listens


class Sample(NamedTuple):
    """What one answer says."""

    ticks: tuple[int, int]  # left, right, as the counters stand
    trouble: str = ""  # why the wheels do not turn although they answer
    hazard: str = ""  # what bumpers, wheel-drop and cliff sensors say
    battery: float | None = None  # 0 to 1
    remedy: bytes = b""  # what to send before the next request


class Answer(NamedTuple):
    """What is to be made of the bytes since a request. Without a sample the answer is incomplete, or nothing is left to wait for."""

    sample: Sample | None = None
    refused: tuple[str, ...] = ()  # what was no answer, by reason
    is_over: bool = False  # nothing more can come


class Firmware(Protocol):
    """The language of one motor controller; holds no state."""

    @property
    def traits(self) -> Traits:
        """Return what never changes about it."""
        ...

    def greeting(self) -> tuple[bytes, ...]:
        """Return what to send, a pause apart, for the controller to listen and to say what it is; the last of it is answered."""
        ...

    def recognises(self, sent: bytes, received: bytes) -> bool:
        """Tell whether what came since the last part of the greeting is this controller's answer."""
        ...

    def command(self, left: int, right: int) -> bytes:
        """Return what sets both speeds, in units. Zero for both stops the wheels, in every mode in which they can turn."""
        ...

    def request(self) -> bytes:
        """Return what asks for the encoders."""
        ...

    def resync(self) -> bytes:
        """Return what ends a command that has lost bytes on its way, without beginning another."""
        ...

    def answer(self, sent: bytes, received: bytes) -> Answer:
        """Return what the bytes mean that came since a request, or a command and a request, was sent."""
        ...
