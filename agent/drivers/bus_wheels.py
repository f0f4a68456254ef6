"""Wheels that turn in a world on the other side of the world's own bus."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from agent.control.twist import within_wheel_speed
from agent.drivers.wheels import WheelCondition
from protocol.bus import Bus
from protocol.messages import WheelCommand, WheelReadings
from protocol.topics import WHEEL_COMMAND, WHEEL_READINGS, WHEELS_READY


class BusWheels:
    """Takes one robot's readings from, and sends its commands over, a session of its own; says there that it is ready."""

    def __init__(self, bus: Bus, robot: str, max_wheel_rad_s: float) -> None:
        self._bus, self._max_wheel_rad_s = bus, max_wheel_rad_s
        self._inbox = bus.inbox(WHEEL_READINGS, robot=robot)
        self._commands = bus.publisher(WHEEL_COMMAND, robot=robot)
        bus.announce(WHEELS_READY, robot=robot)

    @property
    def refused(self) -> Mapping[str, int]:
        """Messages that were no readings, by reason."""
        return self._bus.refused

    @property
    def condition(self) -> WheelCondition:
        """A world's wheels are always well."""
        return WheelCondition()

    @property
    def stops_by_itself_s(self) -> None:
        """A world's motors hold a command until the next."""
        return None

    def read(self, timeout_s: float) -> Sequence[WheelReadings]:
        """Return the readings that have come, waiting for the first."""
        self._bus.wait(timeout_s)
        return self._inbox.take()

    def drive(self, left_rad_s: float, right_rad_s: float, answers_ns: int = 0) -> WheelCommand:
        """Send both speeds, slowed to what the motors can; the world's motors hold them until the next command."""
        left_rad_s, right_rad_s = within_wheel_speed(left_rad_s, right_rad_s, self._max_wheel_rad_s)
        command = WheelCommand(left_rad_s=left_rad_s, right_rad_s=right_rad_s, answers_ns=answers_ns)
        self._commands.put(command)
        return command

    def stop(self) -> None:
        """Stop both wheels."""
        self.drive(0.0, 0.0)

    def close(self) -> None:
        """Leave the world's bus."""
        self._bus.close()
