"""Whose battery counts as low."""

from __future__ import annotations

from mapserver.batteries import Batteries
from protocol.messages import AgentStatus


def status(robot: str, battery: float | None) -> AgentStatus:
    return AgentStatus(
        robot=robot, epoch=0, state="mapping", drive="driving", frames={}, reasons={}, bytes_sent=0, stages={}, battery=battery
    )


def test_robot_is_low_from_below_the_limit_until_it_has_been_charged() -> None:
    batteries = Batteries(0.2)
    told = []
    for charge in (0.3, 0.21, 0.19, 0.25, 0.45, 0.55):
        batteries.note([status("r1", charge)])
        told.append("r1" in batteries.low)
    assert told == [False, False, True, True, True, False]


def test_robot_that_tells_nothing_of_a_battery_is_never_low() -> None:
    batteries = Batteries(0.2)
    batteries.note([status("r1", None), status("r2", 0.1)])
    assert batteries.low == {"r2"}
