"""A serial port that makes nobody wait who does not ask for it, and says in plain words how it was lost."""

from __future__ import annotations

import errno
import os
import select
from contextlib import suppress

import serial

_WRITE_LIMIT_S = 0.1  # a port that takes nothing for so long is lost
_READ_BYTES = 4096
_BITS = 10  # of a byte on the line: start, eight, stop


class LineLost(Exception):
    """The line is gone, or what is at its other end does not answer as it should; the text says how."""


class SerialLine:
    """An open port, raw, 8N1, without flow control."""

    def __init__(self, port: str, baud: int, *, exclusive: bool = True) -> None:
        """Open it; raises LineLost. `exclusive` refuses a port that another program holds in the same way."""
        self._port, self._baud = port, baud
        try:
            self._serial = serial.Serial(port, baud, timeout=0, write_timeout=_WRITE_LIMIT_S, exclusive=exclusive)
        except (serial.SerialException, OSError, ValueError) as error:
            raise LineLost(_why_not_opened(port, error)) from None

    def transfer_s(self, count: int) -> float:
        """Return how long so many bytes are on their way."""
        return _BITS * count / self._baud

    def send(self, data: bytes) -> None:
        """Send all of it; raises LineLost."""
        try:
            self._serial.write(data)
        except serial.SerialTimeoutException:
            raise LineLost("takes nothing any more") from None
        except (serial.SerialException, OSError):
            raise LineLost(self._how_lost()) from None

    def receive(self) -> bytes:
        """Return what has come; raises LineLost."""
        try:
            return bytes(self._serial.read(_READ_BYTES))
        except (serial.SerialException, OSError):
            raise LineLost(self._how_lost()) from None

    def wait(self, timeout_s: float) -> bool:
        """Sleep until something has come, or the line was lost, and tell so; False when the time is over."""
        ready, _, _ = select.select([self._serial], [], [], timeout_s)
        return bool(ready)

    def exists(self) -> bool:
        """Tell whether the port's file is still there."""
        return os.path.exists(self._port)

    def close(self) -> None:
        """Let the port go; calling it again does nothing."""
        with suppress(serial.SerialException, OSError):  # it is gone already
            self._serial.close()

    def _how_lost(self) -> str:
        return "was pulled out" if self.exists() else "is gone"


def _why_not_opened(port: str, error: Exception) -> str:
    if not os.path.exists(port):
        return "is not there"
    number = getattr(error, "errno", None)
    if number in (errno.EACCES, errno.EPERM):
        return "may not be opened by this user (group dialout?)"
    if number in (errno.EAGAIN, errno.EBUSY):
        return "is held by another program"
    return f"cannot be opened: {os.strerror(number) if number else error}"
