"""A serial port that never makes anybody wait, and says in plain words how it was lost."""

from __future__ import annotations

import errno
import os
from contextlib import suppress

import serial

_WRITE_LIMIT_S = 0.1  # a port that takes nothing for so long is lost
_READ_BYTES = 4096


class LineLost(Exception):
    """The line is gone, or what is at its other end does not answer as it should; the text says how."""


class SerialLine:
    """An open port, raw, 8N1, without flow control."""

    def __init__(self, port: str, baud: int, *, exclusive: bool = True) -> None:
        """Open it; raises LineLost. `exclusive` refuses a port that another program holds in the same way."""
        self._port = port
        try:
            self._serial = serial.Serial(port, baud, timeout=0, write_timeout=_WRITE_LIMIT_S, exclusive=exclusive)
        except (serial.SerialException, OSError, ValueError) as error:
            raise LineLost(_why_not_opened(port, error)) from None

    def fileno(self) -> int:
        """Return the descriptor on which something can be read once something has come."""
        return int(self._serial.fileno())

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
