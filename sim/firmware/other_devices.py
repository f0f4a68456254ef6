"""What else may be found on a serial port that should have been the motors': a GPS receiver, which talks and does not listen."""

from __future__ import annotations

_SENTENCE = b"$GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*47\r\n"
_PERIOD_S = 0.2


class GpsReceiver:
    """Says where it is, five times a second (NMEA 0183, sentence GGA)."""

    def __init__(self, baud: int, now_s: float) -> None:
        self._baud, self._next_s = baud, now_s

    @property
    def baud(self) -> int:
        """The speed of its line [bit/s]: that of the board in whose place it is, so that its sentences can be read."""
        return self._baud

    def opened(self, now_s: float) -> None:
        """Go on as before."""

    def reboot(self, now_s: float) -> None:
        """Begin anew."""
        self._next_s = now_s

    def receive(self, byte: int, now_s: float) -> bytes:
        """Hear nothing."""
        return b""

    def turn(self, now_s: float) -> bytes:
        """Return the sentences that are due."""
        said = b""
        while self._next_s <= now_s:
            said += _SENTENCE
            self._next_s += _PERIOD_S
        return said

    def sense(self, sensor: int, value: int) -> None:
        """Refuse."""
        raise ValueError(f"a GPS receiver has no sensor {sensor}")
