"""The answers to one question, as they come; nothing here knows the transport."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

from protocol.codec import decode
from protocol.errors import DecodeError
from protocol.fields import Message
from protocol.inbox import Refusals, Wake
from protocol.topics import Query

M = TypeVar("M", bound=Message)

_MOST = 1024  # answers to one question that may wait


@dataclass(frozen=True)
class Answer(Generic[M]):
    """One answer, and when the question was asked and the answer came [s; monotonic]."""

    message: M
    asked_s: float
    arrived_s: float


class Answers(Generic[M]):
    """The answers to a question that was asked when this was made."""

    def __init__(self, query: Query[M], refusals: Refusals, news: Wake, clock_s: Callable[[], float] = time.monotonic) -> None:
        self._query, self._refusals, self._news, self._clock_s = query, refusals, news, clock_s
        self._asked_s = clock_s()
        self._waiting: deque[tuple[str, bytes, float]] = deque(maxlen=_MOST)

    def keep(self, key: str, data: bytes) -> None:
        """Keep one answer for `take`; called on the transport's threads."""
        self._waiting.append((key, data[: self._query.limit_bytes + 1], self._clock_s()))
        self._news.set()

    def take(self) -> list[Answer[M]]:
        """Return the valid answers that have come since the last call, oldest first."""
        waiting = [self._waiting.popleft() for _ in range(len(self._waiting))]
        return [answer for arrival in waiting if (answer := self._open(*arrival)) is not None]

    def _open(self, key: str, data: bytes, arrived_s: float) -> Answer[M] | None:
        """Return one answer, or None where it had to be refused."""
        try:
            return Answer(decode(data, self._query.message, self._query.limit_bytes), self._asked_s, arrived_s)
        except DecodeError as error:
            self._refusals.add(key, str(error))
            return None
