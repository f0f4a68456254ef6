"""What agent and helm say to each other over their pipe."""

from __future__ import annotations

from pydantic import FiniteFloat

from agent.clocks.clock_map import ClockMap
from agent.drivers.wheels import WheelCondition
from protocol.fields import Count, Message
from protocol.messages import Drive, LocalMap, WheelReadings


class Look(Message):
    """From the agent: what it has seen."""

    local_map: LocalMap
    angles_rad: tuple[FiniteFloat, FiniteFloat]  # of the wheels at its stamp: left, right; since the first reading


class HelmReport(Message):
    """From the helm: what it feels, and how it fares. The first one says that it steers; one with a fault is the last."""

    fault: str  # why the helm ends, in one line; empty while it does not
    readings: WheelReadings | None
    drive: Drive
    why: str  # the robot is not being driven, in one line for a person; empty where there is nothing to say
    wheels: WheelCondition
    refused: dict[str, Count]  # what came in place of setpoints, poses and readings, by reason
    knows_clock: bool = False  # what the map server's clock reads, by a map or by what it announces
    is_linked: bool = True  # to the map server; before it is for the first time, nobody steers
    clock: ClockMap | None = None  # by which frames are to be stamped; None while there is none, and in a world's clock
