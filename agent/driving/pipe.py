"""A pipe between two processes of a robot. No sender ever waits for the other side."""

from __future__ import annotations

import select
import socket
from typing import TypeVar

from protocol.codec import decode, encode
from protocol.fields import Message

M = TypeVar("M", bound=Message)

_LENGTH_BYTES = 4
_LIMIT_BYTES = 2 * 1024 * 1024  # of one message, and of all that wait for a process that does not read
_CHUNK_BYTES = 64 * 1024


class Pipe:
    """One end of a pair of sockets that carries encoded messages, each behind its length; `ended` once the other end is gone."""

    def __init__(self, end: socket.socket) -> None:
        end.setblocking(False)
        self._end = end
        self._incoming = bytearray()
        self._outgoing = bytearray()
        self.ended = False
        self.lost = 0  # messages that the other side was too slow to take

    def send(self, message: Message) -> None:
        """Send a message, or as much as the other side has room for now; what would wait beyond the limit is dropped and counted."""
        data = encode(message)
        if len(self._outgoing) + len(data) > _LIMIT_BYTES:
            self.lost += 1
        else:
            self._outgoing += len(data).to_bytes(_LENGTH_BYTES, "little") + data
        self.flush()

    def flush(self) -> None:
        """Send what waits, as far as there is room."""
        try:
            while self._outgoing and not self.ended:
                del self._outgoing[: self._end.send(self._outgoing)]
        except BlockingIOError:
            pass  # the other side is slow; the rest waits for the next call
        except ConnectionError:
            self.ended = True

    def take(self, message_type: type[M]) -> list[M]:
        """Return the messages that have come whole, oldest first."""
        self._receive()
        messages = []
        while (data := self._next()) is not None:
            messages.append(decode(data, message_type, _LIMIT_BYTES))
        return messages

    def wait(self, timeout_s: float) -> None:
        """Wait until something has come, the other end is gone, or the time is over."""
        select.select([self._end], [], [], timeout_s)

    def fileno(self) -> int:
        """Return the descriptor on which something can be read once the other side has said something, or is gone."""
        return self._end.fileno()

    def close(self) -> None:
        """End the pipe; the other side sees it."""
        self._end.close()

    def _receive(self) -> None:
        try:
            while chunk := self._end.recv(_CHUNK_BYTES):
                self._incoming += chunk
            self.ended = True
        except BlockingIOError:
            pass  # all that has come is here
        except ConnectionError:
            self.ended = True

    def _next(self) -> bytes | None:
        """Return the next whole message's bytes."""
        end = _LENGTH_BYTES + int.from_bytes(self._incoming[:_LENGTH_BYTES], "little")
        if len(self._incoming) < max(end, _LENGTH_BYTES):
            return None
        data = bytes(self._incoming[_LENGTH_BYTES:end])
        del self._incoming[:end]
        return data
