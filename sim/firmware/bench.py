"""The loop of an emulated board: its serial line, orders to its surroundings, and whatever turns its motors."""

from __future__ import annotations

import os
import select
import time
from collections.abc import Callable

from sim.firmware.orders import Surroundings
from sim.firmware.port import SerialPort

_CHUNK = 4096


class Orders:
    """Lines that come in on a descriptor. Whoever closes the other end only says that no more will come."""

    def __init__(self, descriptor: int) -> None:
        self._descriptor = descriptor
        self._begun = b""
        self._ended = False

    @property
    def readable(self) -> tuple[int, ...]:
        """The descriptor on which lines come, while they do."""
        return () if self._ended else (self._descriptor,)

    def take(self) -> list[str]:
        """Return the whole lines that have come; to be called when there is something to read."""
        data = os.read(self._descriptor, _CHUNK)
        self._ended = not data
        *lines, self._begun = (self._begun + data).split(b"\n")
        return [line.decode(errors="replace") for line in lines]


def run(
    port: SerialPort,
    surroundings: Surroundings,
    orders: Orders,
    stopping: Callable[[], bool],
    turn_world: Callable[[float], None] = lambda _now_s: None,
    clock_s: Callable[[], float] = time.monotonic,
) -> None:
    """Turn until asked to stop. Answers to orders go to stdout; `turn_world` is told the time once in every turn."""
    while not stopping():
        now_s = clock_s()
        waiting = (*port.readable, *orders.readable)
        readable, _, _ = select.select(waiting, (), (), max(0.0, port.due_s(now_s) - now_s))
        now_s = clock_s()
        turn_world(now_s)
        port.service(now_s)
        if set(orders.readable) & set(readable):
            for order in orders.take():
                print(surroundings.carry_out(order, now_s), flush=True)
