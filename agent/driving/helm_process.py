"""The agent's side of its helm: starts the process, tells it what there is to be seen, and takes the wheels' readings from it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Self

from agent.clocks.clock_map import ClockMap, ServerStamps
from agent.clocks.local_clock import LocalClock
from agent.drivers.wheels import WheelCondition
from agent.driving.child import START_S, Child
from agent.driving.helm_pipe import HelmReport, Look
from protocol.errors import DriverError
from protocol.geometry import Array
from protocol.messages import Drive, LocalMap, WheelReadings

_END_S = START_S + 5.0  # where its guard was killed, the helm has another one stop the wheels


class HelmProcess:
    """A running helm. Use it as a context manager: the helm has the wheels stopped and ends with it, or with this process.

    `stamps` learns from the helm by what frames are stamped.
    """

    def __init__(self, child: Child, stamps: ServerStamps) -> None:
        self._child, self._stamps = child, stamps
        self._last: HelmReport | None = None

    @classmethod
    def start(cls, config_file: Path, clock: LocalClock, stamps: ServerStamps) -> Self:
        """Start the helm of the robot in a configuration file, by this clock."""
        return cls(Child.start("helm", "agent.driving.helm", config_file, clock), stamps)

    @property
    def refused(self) -> Mapping[str, int]:
        """What the helm and its guard could not take, by reason."""
        return MappingProxyType({}) if self._last is None else self._last.refused

    @property
    def fares(self) -> tuple[Drive, str]:
        """How the robot is being driven, and why it is not, in one line for a person, empty where there is nothing to say."""
        return ("standing", "") if self._last is None else (self._last.drive, self._last.why)

    @property
    def knows_clock(self) -> bool:
        """Whether the helm knows the map server's clock."""
        return self._last is not None and self._last.knows_clock

    @property
    def clock(self) -> ClockMap | None:
        """The map server's clock by the robot's own; None where it is not known, and in a world's clock."""
        return None if self._last is None else self._last.clock

    @property
    def wheels(self) -> WheelCondition:
        """How the wheels fare, as the helm last said."""
        return WheelCondition() if self._last is None else self._last.wheels

    def fileno(self) -> int:
        """Return the descriptor on which something can be read once the helm has said something."""
        return self._child.pipe.fileno()

    def wait_ready(self, stopping: Callable[[], bool]) -> None:
        """Wait until the helm has its wheel guard. Raises DriverError where it fails, Stopped as soon as `stopping` says so."""
        self._child.wait_ready(self._has_reported, stopping)

    def wait_linked(self, stopping: Callable[[], bool]) -> None:
        """Wait until the helm steers, once there is a map server. Raises DriverError where it fails, Stopped as `stopping` says so."""
        self._child.wait_ready(self._is_linked, stopping)

    def see(self, local_map: LocalMap, angles_rad: Array) -> None:
        """Tell the helm of the newest local map, made with the wheels at (2,) [rad]."""
        left_rad, right_rad = angles_rad.tolist()
        self._child.pipe.send(Look(local_map=local_map, angles_rad=(left_rad, right_rad)))

    def take(self) -> list[WheelReadings]:
        """Return the readings that have come, oldest first. Raises DriverError where the helm has ended."""
        reports = self._child.pipe.take(HelmReport)
        if reports and reports[-1].fault:
            raise DriverError(reports[-1].fault)
        if self._child.pipe.ended:
            raise DriverError("the helm was ended by something else; without it no wheel may turn")
        if reports:
            self._last = reports[-1]
            self._stamps.learn(self._last.clock)
        return [report.readings for report in reports if report.readings is not None]

    def close(self) -> None:
        """End the pipe, on which the helm has the wheels stopped and ends."""
        self._child.end(_END_S)

    def _has_reported(self) -> bool:
        self.take()
        return self._last is not None

    def _is_linked(self) -> bool:
        return self._has_reported() and self._last is not None and self._last.is_linked

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
