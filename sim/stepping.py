"""When a simulated world goes on from a stamp to the next: pure waiting rules, told the time by their caller.

Lockstep: when every robot that was there has answered the stamp, so that results never depend on the machine's speed.
Real: whenever it is due; commands count from when they come.
"""

from __future__ import annotations

import logging
from collections import Counter
from typing import Protocol

from protocol.messages import WheelCommand
from sim.real_time import Pace

PATIENCE_S = 10.0  # a robot that owes its answer for so long is not waited for in this step

_log = logging.getLogger(__name__)


class Stepping(Protocol):
    """When the next step may begin. Times are on any monotonic clock [s]."""

    def shown(self, stamp_ns: int, robots: frozenset[str], now_s: float) -> None:
        """Take note that a moment has been handed out to these robots."""
        ...

    def arrived(self, robot: str, command: WheelCommand, arrived_s: float) -> int:
        """Take note of a command, and return the stamp at which it arrived in the world."""
        ...

    def may_go_on(self, present: frozenset[str], now_s: float) -> bool:
        """Tell whether nobody has to be waited for, given who is there."""
        ...


class Lockstep:
    """The world's time stands still until all have answered."""

    def __init__(self) -> None:
        self.given_up: Counter[str] = Counter()  # steps that went on without the answer of a robot that was there
        self._stamp_ns = 0
        self._shown_s = 0.0
        self._owing: frozenset[str] = frozenset()

    def shown(self, stamp_ns: int, robots: frozenset[str], now_s: float) -> None:
        """Wait for an answer from each of these robots."""
        self._stamp_ns, self._shown_s, self._owing = stamp_ns, now_s, robots

    def arrived(self, robot: str, command: WheelCommand, arrived_s: float) -> int:
        """Take note of who has answered; a command arrives at the stamp at which the world stands."""
        if command.answers_ns >= self._stamp_ns:
            self._owing -= {robot}
        return self._stamp_ns

    def may_go_on(self, present: frozenset[str], now_s: float) -> bool:
        """Tell whether all have answered who are still there; those who owe it for 10 s are given up, and named once."""
        self._owing &= present  # one that comes back has not seen this stamp
        if self._owing and now_s - self._shown_s >= PATIENCE_S:
            self._give_up()
        return not self._owing

    def _give_up(self) -> None:
        for robot in sorted(self._owing):
            if not self.given_up[robot]:
                _log.warning("%s has not answered for %g s; the world goes on (from now on such steps are only counted)", robot, PATIENCE_S)
        self.given_up.update(self._owing)
        self._owing = frozenset()


class RealStepping:
    """The world's time runs by itself."""

    def __init__(self, pace: Pace) -> None:
        self._pace = pace
        self._stamp_ns = 0

    def shown(self, stamp_ns: int, robots: frozenset[str], now_s: float) -> None:
        """Take note of the time up to which everything has happened."""
        self._stamp_ns = stamp_ns

    def arrived(self, robot: str, command: WheelCommand, arrived_s: float) -> int:
        """Return what the world's clock showed then; nothing can arrive in the past."""
        return max(self._stamp_ns, self._pace.at_ns(arrived_s))

    def may_go_on(self, present: frozenset[str], now_s: float) -> bool:
        """Wait for nobody."""
        return True
