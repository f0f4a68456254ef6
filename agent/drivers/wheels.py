"""What a pair of driven wheels is to the wheel guard."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Protocol

from pydantic import Field, FiniteFloat

from protocol.fields import Message
from protocol.messages import WheelCommand, WheelReadings

MOST_TROUBLE = 200  # characters

Charge = Annotated[FiniteFloat, Field(ge=0.0, le=1.0)]  # of a battery, as a fraction of what it holds


class WheelCondition(Message):
    """How the wheels fare."""

    trouble: Annotated[str, Field(max_length=MOST_TROUBLE)] = (
        ""  # why they cannot be driven now, in one line for a person; empty while they can
    )
    hazard: Annotated[str, Field(max_length=MOST_TROUBLE)] = (
        ""  # what bumpers, wheel-drop and cliff sensors say now; empty while they say nothing
    )
    battery: Charge | None = None  # None where the hardware does not tell


class Wheels(Protocol):
    """Reads both encoders and sets both speeds.

    Wheels that are lost for now, such as by a pulled line, say so in `condition`; they give no readings and take no speeds until they are
    found again, and whoever lost them stays in place.
    """

    @property
    def refused(self) -> Mapping[str, int]:
        """What came in place of readings and could not be read, by reason."""
        ...

    @property
    def condition(self) -> WheelCondition:
        """How the wheels fare, as of the last read."""
        ...

    @property
    def stops_by_itself_s(self) -> float | None:
        """After how long without a command the hardware stops by itself, as when its line is pulled; None where it never does."""
        ...

    def read(self, timeout_s: float) -> Sequence[WheelReadings]:
        """Return the readings since the last call, oldest first, as soon as there are any; none where none came in time.

        Whoever reads may be woken earlier by something else, and then gets none. Raises DriverError where the wheels are lost for good.
        """
        ...

    def drive(self, left_rad_s: float, right_rad_s: float, answers_ns: int = 0) -> WheelCommand:
        """Set both speeds, finite and slowed by one factor to what the wheels can, and return what was really applied.

        `answers_ns` is the stamp of the setpoints that are answered by it, 0 if none are. Raises DriverError where the wheels are lost for
        good.
        """
        ...

    def stop(self) -> None:
        """Stop both wheels, as far as they can be reached. Raises DriverError where they are lost for good."""
        ...

    def close(self) -> None:
        """Let the wheels go, as they are; calling it again does nothing."""
        ...
