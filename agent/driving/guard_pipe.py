"""What helm and wheel guard say to each other over their pipe."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, FiniteFloat

from agent.clocks.clock_map import ClockMap
from agent.drivers.wheels import WheelCondition
from protocol.fields import Count, Message, StampNs
from protocol.messages import WheelCommand, WheelReadings

ORDER_LIMIT_S = 0.5  # no drive order holds for longer
MOST_REASON = 200  # characters


class DriveOrder(Message):
    """How fast the wheels are to turn, and for how long that may be done without a further order."""

    left_rad_s: FiniteFloat
    right_rad_s: FiniteFloat
    valid_s: Annotated[FiniteFloat, Field(gt=0.0, le=ORDER_LIMIT_S)]
    answers_ns: StampNs  # the stamp of the setpoints that it answers


class LatchOrder(Message):
    """Stop the wheels, whatever else is ordered, until they are released; or release them."""

    order: Literal["stop", "release"]
    reason: Annotated[str, Field(max_length=MOST_REASON)]


class Instruction(Message):
    """From the helm, in every turn of its loop: that it turns, and what is to be done."""

    count: Count
    sent_s: FiniteFloat  # on the machine's monotonic clock, which both read: what has waited in the pipe is as old as that
    drive: DriveOrder | None = None
    latch: LatchOrder | None = None
    clock: ClockMap | None = None  # by which the wheels' readings are to be stamped; None while there is none


class Latch(Message):
    """Whether the wheels are held, why, and how many orders to hold or release them have been heard.

    The guard holds them by itself as soon as a bumper, a wheel-drop or a cliff sensor says anything, and does not release them while one
    does.
    """

    stopped: bool
    reason: Annotated[str, Field(max_length=MOST_REASON)]
    orders: Count


FREE = Latch(stopped=False, reason="", orders=0)  # wheels that nobody holds, and nobody has ordered to be held


class GuardReport(Message):
    """From the guard: what the wheels tell. The first one says that it is ready and the wheels stand; one with a fault is the last."""

    fault: str  # why the guard ends, in one line; empty while it does not
    readings: WheelReadings | None
    applied: WheelCommand  # the speeds that the wheels were last given; a new one is told with the next readings
    latch: Latch
    condition: WheelCondition
    refused: dict[str, Count]  # what came in place of readings, by reason
