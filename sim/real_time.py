"""A simulated world's pace: never faster than real time where that is asked for, and how much slower it was."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Protocol


class Pace(Protocol):
    """When steps are due, on a clock of its own [s], and what is shown of them."""

    @property
    def world_s(self) -> float:
        """World time from the first step to the last."""
        ...

    @property
    def wall_s(self) -> float:
        """Real time in which that has passed."""
        ...

    @property
    def late_steps(self) -> int:
        """How many steps were late."""
        ...

    @property
    def worst_late_s(self) -> float:
        """By how much the worst of them was late."""
        ...

    def due_s(self, stamp_ns: int) -> float:
        """Return when the step with this stamp is due [s; clock]."""
        ...

    def began(self, stamp_ns: int) -> None:
        """Take note that the step with this stamp begins now."""
        ...

    def may_show(self, until_ns: int) -> bool:
        """Tell whether a further picture is still shown in a step that ends at `until_ns`."""
        ...

    def at_ns(self, time_s: float) -> int:
        """Return the stamp that the world's clock shows at a moment [s; clock]."""
        ...


_PUNCTUAL_S = 0.02  # what a step may be late by and the next one makes up for
_LATE_PERIODS = 0.2  # a step that is late by more of its period counts as late


class RealTime:
    """Says when steps are due. What a late step has lost is never caught up: from there on the world is late by so much.

    `rate` is world time over real time at most: 1.0 is real time, `math.inf` as fast as it goes. Real time is the monotonic clock.
    """

    def __init__(self, rate: float, clock_s: Callable[[], float] = time.monotonic) -> None:
        self._rate, self._clock_s = rate, clock_s
        self._first: tuple[int, float] | None = None  # stamp [ns] and beginning [s; clock] of the first step
        self._stamp_ns, self._due_s, self._began_s = 0, 0.0, 0.0  # of the last step
        self.late_steps = 0
        self.worst_late_s = 0.0

    @property
    def world_s(self) -> float:
        """World time from the first step to the last."""
        return (self._stamp_ns - self._first[0]) / 1e9 if self._first else 0.0

    @property
    def wall_s(self) -> float:
        """Real time from the first step to the last."""
        return self._began_s - self._first[1] if self._first else 0.0

    def due_s(self, stamp_ns: int) -> float:
        """Return when the step with this stamp is due [s; clock]; the first is due since ever."""
        return self._due_s + (stamp_ns - self._stamp_ns) / 1e9 / self._rate if self._first else -math.inf

    def began(self, stamp_ns: int) -> None:
        """Take note that the step with this stamp begins now."""
        due_s, self._began_s = self.due_s(stamp_ns), self._clock_s()
        late_s = self._began_s - due_s
        if self._first is None:
            self._first = (stamp_ns, self._began_s)
        elif math.isfinite(self._rate) and late_s > _LATE_PERIODS * (stamp_ns - self._stamp_ns) / 1e9 / self._rate:
            self.late_steps += 1
            self.worst_late_s = max(self.worst_late_s, late_s)
        self._stamp_ns, self._due_s = stamp_ns, self._began_s if late_s > _PUNCTUAL_S else due_s

    def may_show(self, until_ns: int) -> bool:
        """Show everything: whoever is late lets the world be late."""
        return True

    def at_ns(self, time_s: float) -> int:
        """Return the stamp that the world's clock shows at a moment [s; clock] after the last step was due; needs a finite rate."""
        return self._stamp_ns + max(0, round(1e9 * (time_s - self._due_s) * self._rate))
