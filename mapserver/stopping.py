"""The latched stop of the whole swarm: an order holds until it is released, whatever else happens."""

from __future__ import annotations

from collections.abc import Mapping

from protocol.messages import StopState

SERVER = "server"
_LONGEST_REASON = 200


class StopLatch:
    """Whether the swarm is held, and why."""

    def __init__(self) -> None:
        """Start released."""
        self.reason = ""  # empty: not held

    def obey(self, order: Mapping[str, str]) -> StopState:
        """Carry out an order, `order=stop` (with `reason=...`) or `order=release`, and return the state; any other only asks for it."""
        match order.get("order"):
            case "stop":
                self.reason = (order.get("reason") or "stopped by order")[:_LONGEST_REASON]
            case "release":
                self.reason = ""
        return StopState(who=SERVER, stopped=bool(self.reason), reason=self.reason)
