"""How commands of the Open Interface follow each other on the line: an opcode, then as many data bytes as it has."""

from __future__ import annotations

import struct
from typing import NamedTuple

from sim.firmware import create2_tables as oi


class OpcodeCommand(NamedTuple):
    """A whole command."""

    opcode: int
    data: bytes


class OpcodeReader:
    """Puts commands together; a byte that is no opcode where one is due is passed over."""

    def __init__(self) -> None:
        self._opcode: int | None = None
        self._data = b""

    def add(self, byte: int) -> OpcodeCommand | None:
        """Take a byte, and return the command that it completes."""
        if self._opcode is None:
            if byte not in oi.DATA_BYTES and byte not in oi.COUNTED and byte != oi.SONG:
                return None
            self._opcode = byte
        else:
            self._data += bytes((byte,))
        if len(self._data) < _length(self._opcode, self._data):
            return None
        command = OpcodeCommand(self._opcode, self._data)
        self._opcode, self._data = None, b""
        return command


def signed_words(data: bytes) -> tuple[int, ...]:
    """Return data bytes as signed numbers of two bytes, high byte first."""
    return struct.unpack(f">{len(data) // 2}h", data)


def _length(opcode: int, data: bytes) -> int:
    """Return how many data bytes a command has, as far as those that have come tell."""
    if opcode == oi.SONG:
        return oi.SONG_HEAD + (oi.SONG_NOTE * data[1] if len(data) > 1 else 0)
    if opcode in oi.COUNTED:
        return 1 + (oi.COUNTED[opcode] * data[0] if data else 0)
    return oi.DATA_BYTES[opcode]
