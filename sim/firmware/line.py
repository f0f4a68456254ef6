"""One direction of a serial line: bytes take their time, and what can befall them."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from random import Random
from typing import NamedTuple

_BITS = 10  # of a byte on the line: start, eight, stop


@dataclass
class LineFaults:
    """What befalls the bytes of a line, in both directions; may be changed at any time."""

    lost_share: float = 0.0  # of bytes that never arrive
    garbled_share: float = 0.0  # of bytes that arrive as any other
    delay_s: float = 0.0  # by which the board answers late
    echo: bool = False  # the line hands back what is sent to the board


class Arrival(NamedTuple):
    """A byte, and when its last bit has arrived."""

    byte: int
    at_s: float


class Line:
    """Carries bytes one after the other. Times are on any monotonic clock [s]."""

    def __init__(self, faults: LineFaults, seed: int = 0) -> None:
        self._faults, self._random = faults, Random(seed)
        self._on_the_way: deque[Arrival] = deque()
        self._free_s = -math.inf  # when the last byte has arrived

    @property
    def due_s(self) -> float:
        """When the next byte arrives, infinity where none is on its way."""
        return self._on_the_way[0].at_s if self._on_the_way else math.inf

    def put(self, data: bytes, from_s: float, baud: int, garbled: bool = False) -> None:
        """Send bytes from a time on; `garbled` makes another of each, as two ends do that differ in their speed."""
        for byte in data:
            self._free_s = max(self._free_s, from_s) + _BITS / baud
            if self._random.random() < self._faults.lost_share:
                continue
            if garbled or self._random.random() < self._faults.garbled_share:
                byte = self._random.randrange(256)
            self._on_the_way.append(Arrival(byte, self._free_s))

    def take(self, now_s: float) -> list[Arrival]:
        """Return the bytes that have arrived."""
        arrived: list[Arrival] = []
        while self._on_the_way and self._on_the_way[0].at_s <= now_s:
            arrived.append(self._on_the_way.popleft())
        return arrived

    def cut(self) -> None:
        """Lose what is on its way."""
        self._on_the_way.clear()
