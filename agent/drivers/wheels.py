"""What a pair of driven wheels is to the wheel guard."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

from protocol.messages import WheelCommand, WheelReadings


class Wheels(Protocol):
    """Reads both encoders and sets both speeds."""

    @property
    def refused(self) -> Mapping[str, int]:
        """What came in place of readings and could not be read, by reason."""
        ...

    def read(self, timeout_s: float) -> Sequence[WheelReadings]:
        """Return the readings since the last call, oldest first, as soon as there are any; none where none came in time.

        Whoever reads may be woken earlier by something else, and then gets none. Wheels that speak only when asked are asked once, at
        the end of that time. Raises DriverError where the wheels are lost.
        """
        ...

    def drive(self, left_rad_s: float, right_rad_s: float, answers_ns: int = 0) -> WheelCommand:
        """Set both speeds, finite and slowed by one factor to what the wheels can, and return what was really applied.

        `answers_ns` is the stamp of the setpoints that are answered by it, 0 if none are. Raises DriverError where the wheels are lost.
        """
        ...

    def stop(self) -> None:
        """Stop both wheels. Raises DriverError where the wheels are lost."""
        ...

    def close(self) -> None:
        """Let the wheels go, as they are; calling it again does nothing."""
        ...
