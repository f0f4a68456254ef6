"""Whose battery is low, from what the robots' agents say."""

from __future__ import annotations

from collections.abc import Iterable

from protocol.messages import AgentStatus

_RECHARGED = 0.3  # by which a battery has to be above the limit to count as charged again: it recovers a little while it rests


class Batteries:
    """Keeps who is low; robots that tell nothing of a battery never are."""

    def __init__(self, low: float) -> None:
        """Take a charge below `low`, as a fraction of the whole, for low."""
        self._low = low
        self._robots: set[str] = set()

    @property
    def low(self) -> frozenset[str]:
        """Return the robots whose battery is low."""
        return frozenset(self._robots)

    def note(self, statuses: Iterable[AgentStatus]) -> None:
        """Take what agents have said."""
        for status in statuses:
            if status.battery is None:
                continue
            if status.battery < self._low:
                self._robots.add(status.robot)
            elif status.battery > self._low + _RECHARGED:
                self._robots.discard(status.robot)
