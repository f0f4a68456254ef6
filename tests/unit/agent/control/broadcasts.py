"""Setpoint broadcasts for the tests of whoever hears them."""

from __future__ import annotations

from protocol.fields import PoseTuple
from protocol.messages import Setpoint, Setpoints

MS = 1_000_000
VALID_MS = 500


def broadcast(
    stamp_ms: int,
    seq: int,
    *,
    epoch: int = 1,
    pose: PoseTuple = (0.0, 0.0, 0.0),
    speed_m_s: float = 0.15,
    turn_rad_s: float = 0.0,
    robot: str = "r1",
) -> Setpoints:
    """Return a broadcast for one robot."""
    setpoint = Setpoint(robot=robot, arena_from_body=pose, speed_m_s=speed_m_s, turn_rad_s=turn_rad_s)
    return Setpoints(epoch=epoch, seq=seq, stamp_ns=stamp_ms * MS, valid_until_ns=(stamp_ms + VALID_MS) * MS, robots=(setpoint,))
