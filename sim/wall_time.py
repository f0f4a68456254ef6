"""A simulated world's pace where its clock is the wall's: what is late is caught up, and what would be shown too late is not shown."""

from __future__ import annotations

import time
from collections.abc import Callable


class WallTime:
    """Says when steps are due: a stamp is a time of the wall clock [ns since 1970], as a camera on a robot stamps its pictures.

    The wall clock is read once, in the beginning, and then goes on with the monotonic one. So stamps agree to the clock of any other
    process on this machine as long as nobody sets it.
    """

    def __init__(self, clock_s: Callable[[], float] = time.monotonic, wall_ns: Callable[[], int] = time.time_ns) -> None:
        self._clock_s = clock_s
        self._began_s, self._start_ns = clock_s(), wall_ns()
        self._stamp_ns = self._start_ns  # of the last step
        self.late_steps = 0  # pictures that came too late
        self.worst_late_s = 0.0

    @property
    def start_ns(self) -> int:
        """The wall time at which this was made, from which on steps can be due."""
        return self._start_ns

    @property
    def world_s(self) -> float:
        """World time from the beginning to the last step."""
        return (self._stamp_ns - self._start_ns) / 1e9

    @property
    def wall_s(self) -> float:
        """Real time from the beginning to now."""
        return self._clock_s() - self._began_s

    def due_s(self, stamp_ns: int) -> float:
        """Return when the step with this stamp is due [s; clock]."""
        return self._began_s + (stamp_ns - self._start_ns) / 1e9

    def began(self, stamp_ns: int) -> None:
        """Take note that the step with this stamp begins now."""
        self._stamp_ns = stamp_ns

    def may_show(self, until_ns: int) -> bool:
        """Tell whether a further picture comes in time, which is before the next step, at `until_ns`, is due; else it counts as late."""
        late_s = self._clock_s() - self.due_s(until_ns)
        if late_s >= 0.0:
            self.late_steps += 1
            self.worst_late_s = max(self.worst_late_s, late_s)
        return late_s < 0.0

    def at_ns(self, time_s: float) -> int:
        """Return what the world's clock shows at a moment [s; clock]."""
        return self._start_ns + round(1e9 * (time_s - self._began_s))
