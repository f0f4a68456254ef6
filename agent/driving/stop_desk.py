"""Where orders to stop the robot for good, or to release it, come in and are answered once the wheel guard has carried them out."""

from __future__ import annotations

from collections import deque
from typing import Literal, Protocol

from agent.driving.guard_pipe import Latch, LatchOrder
from protocol.bus import Bus
from protocol.inbox import PendingQuery
from protocol.messages import StopState
from protocol.topics import AGENT_STOP

_REASON_CHARACTERS = 200


class Latching(Protocol):
    """What the desk needs of the wheel guard."""

    @property
    def latch(self) -> Latch:
        """Whether the guard holds the wheels, as it last said."""
        ...

    def instruct(self, *, latch: LatchOrder) -> None:
        """Tell the guard to hold or to release."""
        ...


class StopDesk:
    """Answers one robot's AGENT_STOP. A question without a known order changes nothing, and is answered with how things are."""

    def __init__(self, bus: Bus, robot: str, guard: Latching) -> None:
        self._robot, self._guard = robot, guard
        self._queries = bus.queries(AGENT_STOP, robot=robot)
        self._ordered = 0
        self._waiting: deque[tuple[int, PendingQuery[StopState]]] = deque()

    def turn(self) -> None:
        """Pass on the orders that have come, and answer those that the guard has confirmed."""
        for query in self._queries.take():
            self._pass_on(query)
            self._waiting.append((self._ordered, query))
        latch = self._guard.latch
        while self._waiting and self._waiting[0][0] <= latch.orders:
            self._waiting.popleft()[1].reply(StopState(who=self._robot, stopped=latch.stopped, reason=latch.reason))

    def _pass_on(self, query: PendingQuery[StopState]) -> None:
        order: Literal["stop", "release"]
        match query.parameters.get("order"):
            case "stop":
                order = "stop"
            case "release":
                order = "release"
            case _:
                return
        self._ordered += 1
        self._guard.instruct(latch=LatchOrder(order=order, reason=query.parameters.get("reason", "")[:_REASON_CHARACTERS]))
