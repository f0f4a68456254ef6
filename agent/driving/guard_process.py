"""The helm's side of its wheel guard: starts the process, keeps it convinced, and takes the wheels' readings from it."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Self

from agent.clocks.clock_map import ClockMap
from agent.clocks.local_clock import LocalClock
from agent.drivers.wheels import WheelCondition
from agent.driving.child import START_S, Child
from agent.driving.guard_pipe import FREE, DriveOrder, GuardReport, Instruction, Latch, LatchOrder
from protocol.errors import DriverError
from protocol.messages import WheelReadings
from protocol.stopping import Stopped

_END_S = 1.0
ENDED_WELL = {0, 2}  # with the wheels stopped: asked to end, or by an error that it has told


_log = logging.getLogger(__name__)


class GuardProcess:
    """A running wheel guard. Use it as a context manager: the guard stops the wheels and ends with it, or with this process.

    A guard that was killed could not stop the wheels. A successor is then started, which begins by that.
    """

    def __init__(self, child: Child, successor: Callable[[], Child] | None = None) -> None:
        self._child, self._successor = child, successor
        self._instructions = 0
        self._clock_map: ClockMap | None = None
        self._last: GuardReport | None = None

    @classmethod
    def start(cls, config_file: Path, clock: LocalClock) -> Self:
        """Start the guard of the robot in a configuration file, by this clock."""
        spawn = partial(Child.start, "wheel guard", "agent.driving.guard", config_file, clock)
        return cls(spawn(), spawn)

    @property
    def refused(self) -> Mapping[str, int]:
        """What the guard could not read, by reason."""
        return MappingProxyType({}) if self._last is None else self._last.refused

    @property
    def latch(self) -> Latch:
        """Whether the guard holds the wheels."""
        return FREE if self._last is None else self._last.latch

    @property
    def condition(self) -> WheelCondition:
        """How the wheels fare, as the guard last said."""
        return WheelCondition() if self._last is None else self._last.condition

    def fileno(self) -> int:
        """Return the descriptor on which something can be read once the guard has said something."""
        return self._child.pipe.fileno()

    def wait_ready(self, stopping: Callable[[], bool]) -> None:
        """Wait until the guard has its wheels, and they stand. Raises DriverError where it fails, Stopped as soon as `stopping` says so."""
        self._child.wait_ready(self._has_reported, stopping)

    def instruct(self, drive: DriveOrder | None = None, latch: LatchOrder | None = None) -> None:
        """Tell the guard that the helm's loop turns, and what to do."""
        self._child.pipe.send(
            Instruction(count=self._instructions, sent_s=time.monotonic(), drive=drive, latch=latch, clock=self._clock_map)
        )
        self._instructions += 1

    def stamp_by(self, clock_map: ClockMap | None) -> None:
        """Have every instruction from now on tell the guard by what to stamp."""
        self._clock_map = clock_map

    def take(self) -> list[WheelReadings]:
        """Return the readings that have come, oldest first. Raises DriverError where the guard has ended."""
        reports = self._child.pipe.take(GuardReport)
        if reports and reports[-1].fault:
            raise DriverError(f"wheel guard: {reports[-1].fault}")
        if self._child.pipe.ended:
            raise DriverError("the wheel guard was ended by something else; without it no wheel may turn")
        if reports:
            self._last = reports[-1]
        return [report.readings for report in reports if report.readings is not None]

    def close(self) -> None:
        """End the pipe, on which the guard stops the wheels and ends; one that does not is killed."""
        exit_code = self._child.end(_END_S)
        if exit_code not in ENDED_WELL and self._last is not None:  # before its first report it has not touched the wheels
            self._stop_wheels_anew()

    def _has_reported(self) -> bool:
        self.take()
        return self._last is not None

    def _stop_wheels_anew(self) -> None:
        """Have another guard stop the wheels; called once, since that one has no successor."""
        if self._successor is None:
            return
        _log.error("the wheel guard was killed or failed; another one stops the wheels")
        deadline_s = time.monotonic() + START_S
        with GuardProcess(self._successor()) as successor, suppress(Stopped):
            successor.wait_ready(lambda: time.monotonic() > deadline_s)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
