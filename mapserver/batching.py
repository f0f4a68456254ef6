"""When local maps are merged, and which together: pure waiting rules, told the time by their caller.

A world's clock: everything captured up to a stamp is merged at once, when all robots have delivered, so that results never
depend on the machine's speed. Wall clock: in the order of stamps, after a short window in which the slower link may catch up.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from typing import NamedTuple, Protocol

from protocol.messages import LocalMap, WorldTime

SILENCE_LIMIT_S = 5.0  # a robot that is waited for and says nothing for so long is left behind
REORDER_WINDOW_S = 0.05


class Batch(NamedTuple):
    """Local maps to merge in one step, by stamp and then by robot, and the stamp at which poses are due."""

    stamp_ns: int
    local_maps: tuple[LocalMap, ...]
    missing: tuple[str, ...] = ()  # robots that should have delivered but are gone or silent


class Batches(Protocol):
    """Where accepted local maps wait for their turn. Times are on any monotonic clock [s]."""

    def announce(self, world_time: WorldTime) -> None:
        """Take note that the world has handed out every frame of a stamp."""
        ...

    def offer(self, local_map: LocalMap, now_s: float) -> None:
        """Let a local map wait."""
        ...

    def forgo(self, robot: str, stamp_ns: int) -> None:
        """Take note that a robot's local map of a stamp was lost on its way."""
        ...

    def take(self, present: frozenset[str], now_s: float) -> Batch | None:
        """Return the next batch if it is due, given who is present on the bus."""
        ...


class WorldBatches:
    """One batch for every stamp that the world announces."""

    def __init__(self, robots: Iterable[str]) -> None:
        """Wait for these robots, as far as a stamp names them."""
        self._robots = frozenset(robots)
        self._stamps: deque[WorldTime] = deque()
        self._waiting: list[LocalMap] = []
        self._lost_ns: dict[str, int] = {}  # the newest stamp whose local map was lost, by robot
        self._came: frozenset[str] = frozenset()
        self._left: frozenset[str] = frozenset()  # went, and have not delivered since
        self._silent_since_s: dict[str, float] = {}

    def announce(self, world_time: WorldTime) -> None:
        """Queue a stamp."""
        self._stamps.append(world_time)

    def offer(self, local_map: LocalMap, now_s: float) -> None:
        """Keep a local map until its stamp is due."""
        self._silent_since_s.pop(local_map.robot, None)
        self._left -= {local_map.robot}
        self._waiting.append(local_map)

    def forgo(self, robot: str, stamp_ns: int) -> None:
        """Wait no longer for a robot's local map of a stamp."""
        self._lost_ns[robot] = max(stamp_ns, self._lost_ns.get(robot, stamp_ns))

    def take(self, present: frozenset[str], now_s: float) -> Batch | None:
        """Return the oldest stamp's batch once every robot that it names has delivered, is gone, or has been silent for 5 s.

        A robot that went and came back is waited for from its next local map on: what fired before that it may never have seen.
        """
        self._left |= self._came - present
        self._came |= present
        if not self._stamps:
            return None
        stamp_ns, named = self._stamps[0].stamp_ns, self._stamps[0].robots
        delivered = {local_map.robot for local_map in self._waiting if local_map.stamp_ns >= stamp_ns}
        lost = {robot for robot, lost_ns in self._lost_ns.items() if lost_ns >= stamp_ns}
        missing = sorted(self._robots.intersection(named) - delivered - lost)
        given_up = [robot for robot in missing if self._is_given_up(robot, present, now_s)]
        if given_up != missing:
            return None
        self._stamps.popleft()
        return Batch(stamp_ns, self._release(stamp_ns), tuple(missing))

    def _is_given_up(self, robot: str, present: frozenset[str], now_s: float) -> bool:
        since_s = self._silent_since_s.setdefault(robot, now_s)
        return robot in self._left or now_s - since_s >= SILENCE_LIMIT_S

    def _release(self, stamp_ns: int) -> tuple[LocalMap, ...]:
        due = [local_map for local_map in self._waiting if local_map.stamp_ns <= stamp_ns]
        self._waiting = [local_map for local_map in self._waiting if local_map.stamp_ns > stamp_ns]
        return _in_order(due)


class _Arrival(NamedTuple):
    local_map: LocalMap
    arrived_s: float


class WallBatches:
    """Batches in the order of stamps, held back for the reorder window; who is behind merges all that has waited so long at once."""

    def __init__(self) -> None:
        """Start with nobody waiting."""
        self._waiting: list[_Arrival] = []

    def announce(self, world_time: WorldTime) -> None:
        """Ignore it: on the wall clock nobody announces stamps."""

    def forgo(self, robot: str, stamp_ns: int) -> None:
        """Ignore it: on the wall clock nobody is waited for by name."""

    def offer(self, local_map: LocalMap, now_s: float) -> None:
        """Keep a local map for the reorder window."""
        self._waiting.append(_Arrival(local_map, now_s))

    def take(self, present: frozenset[str], now_s: float) -> Batch | None:
        """Return the oldest local map, all that have waited and all within the window behind it, once nothing older can come."""
        if not self._waiting:
            return None
        waited_ns = [each.local_map.stamp_ns for each in self._waiting if now_s - each.arrived_s >= REORDER_WINDOW_S]
        oldest_ns = min(arrival.local_map.stamp_ns for arrival in self._waiting)
        if oldest_ns not in waited_ns and not present <= {arrival.local_map.robot for arrival in self._waiting}:
            return None
        return self._release(max([oldest_ns + round(REORDER_WINDOW_S * 1e9), *waited_ns]))

    def _release(self, until_ns: int) -> Batch:
        due = _in_order(arrival.local_map for arrival in self._waiting if arrival.local_map.stamp_ns <= until_ns)
        self._waiting = [arrival for arrival in self._waiting if arrival.local_map.stamp_ns > until_ns]
        return Batch(due[-1].stamp_ns, due)


def _in_order(local_maps: Iterable[LocalMap]) -> tuple[LocalMap, ...]:
    return tuple(sorted(local_maps, key=lambda local_map: (local_map.stamp_ns, local_map.robot)))
