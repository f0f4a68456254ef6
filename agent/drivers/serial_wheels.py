"""Wheels behind a motor controller on a serial line, whichever its language."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence

from agent.control.twist import within_wheel_speed
from agent.drivers.connection import Connection
from agent.drivers.encoders import Encoders
from agent.drivers.firmware import Firmware
from agent.drivers.polling import Polling, Timed
from agent.drivers.serial_line import LineLost
from agent.drivers.wheels import MOST_TROUBLE, WheelCondition
from protocol.fields import Packed
from protocol.messages import WheelCommand, WheelReadings

CLOCK_UNKNOWN = "readings: the map server's clock is not known yet"
JUMPED = "encoders: counted anew"
UNREACHABLE = "encoders: counts that no wheel could have reached"

_TOGETHER = 2  # readings in one message: each wakes the helm
_STANDING = (0, 0)


class SerialWheels:
    """Drives one pair of wheels, and looks for it again where it was lost.

    `stamp_ns` turns the local monotonic clock [ns] into stamps in the map server's clock, None while that is not known: then nothing is
    handed out. Of a time in which the line was lost nothing is told: the angles go on where they were.
    """

    def __init__(
        self,
        port: str,
        baud: int,
        firmware: Firmware,
        max_wheel_rad_s: float,
        stamp_ns: Callable[[int], int | None],
    ) -> None:
        self._port, self._firmware, self._stamp_ns = port, firmware, stamp_ns
        traits = firmware.traits
        self._unit_rad_s = traits.unit_rad_s
        self._max_wheel_rad_s = min(max_wheel_rad_s, traits.max_units * traits.unit_rad_s)
        self._connection = Connection(port, baud, firmware)
        self._encoders = Encoders(traits, self._max_wheel_rad_s)
        self._polling: Polling | None = None  # while the controller is there
        self._units = _STANDING
        self._stamped: list[tuple[int, tuple[float, float]]] = []  # readings that are not handed out yet: stamp [ns], angles [rad]
        self._counts: Counter[str] = Counter()
        self._condition = WheelCondition(trouble=self._trouble())

    @property
    def refused(self) -> Mapping[str, int]:
        """What came in place of readings, by reason, and how often the line was lost."""
        encoders = Counter({JUMPED: self._encoders.jumps, UNREACHABLE: self._encoders.garbled})
        return self._counts + encoders

    @property
    def condition(self) -> WheelCondition:
        """How the wheels fare, as of the last read."""
        return self._condition

    @property
    def stops_by_itself_s(self) -> float | None:
        """After how long without a command the hardware stops by itself; None where it never does."""
        return self._firmware.traits.stops_by_itself_s

    def read(self, timeout_s: float) -> Sequence[WheelReadings]:
        """Return the readings that there are, two at a time; read again at once, so that the next is asked for in time."""
        if self._polling is None:
            self._look_for_wheels(timeout_s)
            return []
        try:
            timed = self._polling.turn(self._units, timeout_s)
        except LineLost as lost:
            self._lose(lost)
            return []
        if timed is not None:
            self._note(timed)
        return self._taken() if len(self._stamped) >= _TOGETHER else []

    def drive(self, left_rad_s: float, right_rad_s: float, answers_ns: int = 0) -> WheelCommand:
        """Set both speeds with the next request, rounded to what the controller knows; wheels that are lost, or in trouble, stand."""
        if self._polling is not None and not self._condition.trouble:
            left_rad_s, right_rad_s = within_wheel_speed(left_rad_s, right_rad_s, self._max_wheel_rad_s)
            self._units = round(left_rad_s / self._unit_rad_s), round(right_rad_s / self._unit_rad_s)
        left, right = self._units
        return WheelCommand(left_rad_s=left * self._unit_rad_s, right_rad_s=right * self._unit_rad_s, answers_ns=answers_ns)

    def stop(self) -> None:
        """Stop both wheels at once, even those of a controller that has not said yet who it is."""
        self._units = _STANDING
        line = self._connection.line
        if line is None:
            return
        try:
            line.send(self._firmware.command(*_STANDING))
        except LineLost as lost:
            self._lose(lost)

    def close(self) -> None:
        """Let the port go."""
        self._polling = None
        self._connection.close()

    def _look_for_wheels(self, timeout_s: float) -> None:
        """Take the next step towards finding the wheels."""
        time.sleep(min(timeout_s, max(self._connection.due_s - time.monotonic(), 0.0)))
        self._connection.turn()
        if self._connection.is_ready and self._connection.line is not None:  # the first answer ends what the trouble was
            self._encoders.begin_anew()
            self._polling = Polling(self._connection.line, self._firmware, self._counts)
        else:
            self._condition = WheelCondition(trouble=self._trouble(), battery=self._condition.battery)

    def _lose(self, lost: LineLost) -> None:
        """Let the wheels stand from here on, as far as that can be had, and look for them."""
        self._polling, self._units = None, _STANDING
        self._counts[f"line: {lost}"] += 1
        self._connection.lose(str(lost))
        self._condition = WheelCondition(trouble=self._trouble(), battery=self._condition.battery)

    def _note(self, timed: Timed) -> None:
        """Keep a sample as a reading, where encoders and clock allow it, and how the wheels fare in any case."""
        sample = timed.sample
        self._condition = WheelCondition(trouble=sample.trouble, hazard=sample.hazard, battery=sample.battery)
        if sample.trouble:
            self._units = _STANDING
        angles_rad = self._encoders.angles_rad(sample.ticks, timed.at_ns)
        if angles_rad is None:
            return
        stamp_ns = self._stamp_ns(timed.at_ns)
        if stamp_ns is None:
            self._counts[CLOCK_UNKNOWN] += 1
        else:
            self._stamped.append((stamp_ns, angles_rad))

    def _taken(self) -> list[WheelReadings]:
        """Return the readings that wait, in one message."""
        stamps_ns, angles_rad = zip(*self._stamped, strict=True)
        self._stamped = []
        return [WheelReadings(until_ns=stamps_ns[-1], stamps_ns=Packed.of(stamps_ns, "i8"), angles_rad=Packed.of(angles_rad, "f8"))]

    def _trouble(self) -> str:
        return f"wheels: {self._connection.trouble}"[:MOST_TROUBLE] if self._connection.trouble else ""
