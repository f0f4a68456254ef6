"""How the motor controller at a port is found, and found again after it was lost: no step of it waits."""

from __future__ import annotations

import time
from collections.abc import Callable

from agent.drivers.firmware import Firmware
from agent.drivers.serial_line import LineLost, SerialLine

_PAUSE_S = 0.05  # between two parts of a greeting; a Create 2 wants 20 ms between two changes of its mode
_ANSWER_S = 0.2  # after the last part, before the greeting begins again
_GREETING_S = 1.0  # after which whoever is there is somebody else
_FIRST_RETRY_S, _LAST_RETRY_S = 0.1, 1.0  # each retry waits twice as long as the one before
_SHOWN_BYTES = 32


class Connection:
    """Opens the port, has the wheels stop, lets the controller come up, and greets it until it says who it is."""

    def __init__(self, port: str, baud: int, firmware: Firmware, clock_s: Callable[[], float] = time.monotonic) -> None:
        self._port, self._baud, self._firmware, self._clock_s = port, baud, firmware, clock_s
        self._line: SerialLine | None = None
        self._is_ready = False
        self._due_s = clock_s()  # of the next step
        self._deadline_s = 0.0  # of the greeting
        self._retry_s = _FIRST_RETRY_S
        self._parts = firmware.greeting()
        self._next_part = 0
        self._sent, self._received, self._all_received = b"", b"", b""
        self.trouble = f"{port} is not open yet"  # empty once the controller has answered

    @property
    def line(self) -> SerialLine | None:
        """Return the open line, whether or not anybody has answered yet."""
        return self._line

    @property
    def is_ready(self) -> bool:
        """Tell whether the controller has said who it is."""
        return self._is_ready

    @property
    def due_s(self) -> float:
        """Return when the next step is due, should nothing come before."""
        return self._due_s

    def turn(self) -> None:
        """Do what is due."""
        try:
            if self._line is None:
                self._open()
            else:
                self._greet(self._line)
        except LineLost as lost:
            self.lose(str(lost))

    def lose(self, how: str) -> None:
        """Give the line up, the wheels stopped if they can still be reached, and try again after a while."""
        if self._line is not None:
            self._say_stop(self._line)
            self._line.close()
        self._line, self._is_ready = None, False
        self.trouble = f"{self._port} {how}; trying again"
        self._due_s = self._clock_s() + self._retry_s
        self._retry_s = min(2.0 * self._retry_s, _LAST_RETRY_S)

    def close(self) -> None:
        """Let the port go, as it is."""
        if self._line is not None:
            self._line.close()
        self._line, self._is_ready = None, False

    def _open(self) -> None:
        if self._clock_s() < self._due_s:
            return
        self._line = SerialLine(self._port, self._baud)
        self._line.send(self._firmware.command(0, 0))  # a controller that did not restart may still drive
        self._due_s = self._clock_s() + self._firmware.traits.settle_s
        self._deadline_s = self._due_s + _GREETING_S
        self._next_part, self._sent, self._received, self._all_received = 0, b"", b"", b""

    def _greet(self, line: SerialLine) -> None:
        came = line.receive()
        self._received += came
        self._all_received = (self._all_received + came)[:_SHOWN_BYTES]
        if self._is_answered():
            self._is_ready, self.trouble, self._retry_s = True, "", _FIRST_RETRY_S
        elif self._clock_s() >= self._deadline_s:
            raise LineLost(self._stranger())
        elif self._clock_s() >= self._due_s:
            self._send_part(line)

    def _is_answered(self) -> bool:
        return self._next_part == len(self._parts) and self._firmware.recognises(self._sent, self._received)

    def _send_part(self, line: SerialLine) -> None:
        """Send the greeting's next part, or begin it again."""
        self._next_part %= len(self._parts)
        self._sent, self._received = self._parts[self._next_part], b""
        line.send(self._sent)
        self._next_part += 1
        self._due_s = self._clock_s() + (_ANSWER_S if self._next_part == len(self._parts) else _PAUSE_S)

    def _stranger(self) -> str:
        """Return who answers in place of the controller."""
        name = self._firmware.traits.name
        if not self._all_received:
            return f"does not answer as {name}"
        if self._received == self._sent:
            return "only echoes what is sent: is anything connected to it?"
        return f"answers, but not as {name}: {self._all_received!r}"

    def _say_stop(self, line: SerialLine) -> None:
        try:
            line.send(self._firmware.command(0, 0))
        except LineLost:
            return  # nobody can reach the wheels any more
