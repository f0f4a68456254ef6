"""The world's own router, on which a player hands out what robots' metal would tell."""

from __future__ import annotations

from typing import Self

from protocol.bus import Bus


class WorldRouter:
    """Publishes on the bus that it is given, which ends with it; announces nothing and starts no thread. Use it as a context manager."""

    def __init__(self, world: Bus) -> None:
        self._world = world

    @property
    def endpoint(self) -> str:
        """Where the robots' drivers connect to."""
        return self._world.endpoint

    def close(self) -> None:
        """Close the world's router."""
        self._world.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
