"""The text protocol of the ROSArduinoBridge firmware (github.com/hbrobotics/ros_arduino_bridge, commands.h and ROSArduinoBridge.ino).

A command is a letter and up to two numbers, ended by CR; an answer is a line, ended by CR LF. `e` tells both encoder counts, 32 bits each;
`m` sets both speeds in encoder ticks per PID interval, and is answered OK; `u` sets the gains of the PID loop; `b` tells the baud rate,
with or without a blank before it, as the version of the firmware has it. What the firmware does not understand it answers with Invalid
Command. It stops the wheels itself 2 s after the last `m` (AUTO_STOP_INTERVAL). Raw PWM (`o`, in older versions only) and resetting the
encoders (`r`) are not needed: the PID loop drives, and counts may begin anywhere.
"""

from __future__ import annotations

import math
import re

from agent.drivers.firmware import ECHO, GARBLED, Answer, Sample, Traits

NOT_UNDERSTOOD = "command: not understood"

_AUTO_STOP_S = 2.0
_LARGEST = 32767  # atoi on the board gives an int of 16 bits

_ENCODERS = re.compile(rb"(-?\d{1,10}) (-?\d{1,10})")
_END_OF_LINE = re.compile(rb"[\r\n]+")


class RosArduinoBridge:
    """The language of one board. `pid` are the gains Kp, Kd, Ki, Ko; without them the firmware keeps its own."""

    def __init__(
        self, ticks_per_revolution: float, pid_rate_hz: int, baud: int, pid: tuple[int, int, int, int] | None, settle_s: float
    ) -> None:
        self._baud, self._pid = baud, pid
        pid_interval_s = 1e-3 * (1000 // pid_rate_hz)  # PID_INTERVAL: whole milliseconds
        self._traits = Traits(
            name="ROSArduinoBridge",
            ticks_per_revolution=ticks_per_revolution,
            counter_bits=32,
            unit_rad_s=2.0 * math.pi / (ticks_per_revolution * pid_interval_s),
            max_units=_LARGEST,
            stops_by_itself_s=_AUTO_STOP_S,
            acknowledgement=b"OK\r\n",
            settle_s=settle_s,
        )

    @property
    def traits(self) -> Traits:
        """Return what never changes about it."""
        return self._traits

    def greeting(self) -> tuple[bytes, ...]:
        """Return the end of whatever was half said, the gains, and the question for the baud rate."""
        gains = () if self._pid is None else (b"u %d:%d:%d:%d\r" % self._pid,)
        return (b"\r", *gains, b"b\r")

    def recognises(self, sent: bytes, received: bytes) -> bool:
        """Tell whether the board has said its baud rate: no other device would."""
        return b"%d" % self._baud in [line.strip() for line in _lines(received)]

    def command(self, left: int, right: int) -> bytes:
        """Return `m` with both speeds in ticks per PID interval."""
        return b"m %d %d\r" % (left, right)

    def request(self) -> bytes:
        """Return `e`."""
        return b"e\r"

    def resync(self) -> bytes:
        """Return nothing: every command ends with its line."""
        return b""

    def answer(self, sent: bytes, received: bytes) -> Answer:
        """Return the encoder counts, from the first line that holds any."""
        refused: list[str] = []
        echoes = _lines(sent)
        for line in _lines(received):
            counts = _ENCODERS.fullmatch(line)
            if counts is not None:
                return Answer(Sample((int(counts[1]), int(counts[2]))), tuple(refused))
            if line != b"OK":
                refused.append(ECHO if line in echoes else NOT_UNDERSTOOD if line == b"Invalid Command" else GARBLED)
        is_over = len(_lines(received)) - refused.count(ECHO) >= len(echoes)  # each command has had its line
        return Answer(refused=tuple(refused), is_over=is_over and len(refused) > refused.count(ECHO))


def _lines(data: bytes) -> list[bytes]:
    """Return the lines that have come whole."""
    return [line for line in _END_OF_LINE.split(data)[:-1] if line]
