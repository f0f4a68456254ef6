"""The iRobot Create 2 Open Interface, which Roombas of the 600 series speak as well (Open Interface Specification of 2018).

Commands are an opcode and its data bytes, numbers high byte first; nothing but a query is answered, and an answer is the bare data of the
packets that were asked for, without frame or checksum. So every value that has a range is held against it, those at both ends of the
answer too.

Start (128) wakes the interface in passive mode, in which nothing can be driven; safe (131) lets it be driven. In safe mode the robot stops
its motors and falls back to passive mode when a wheel drops, when it meets a cliff driving forward, and when a charger is plugged in. It
does not stop when commands stay away: whoever drives it has to stop it, and a line that is pulled leaves it driving.
"""

from __future__ import annotations

import struct
from typing import NamedTuple

from agent.drivers.firmware import ECHO, GARBLED, Answer, Sample, Traits

START, SAFE, DRIVE_DIRECT, QUERY_LIST = 128, 131, 145, 149

WHEEL_RADIUS_M = 0.036
TICKS_PER_REVOLUTION = 508.8

_MAX_MM_S = 500  # Drive Direct
_PASSIVE_MODE, _SAFE_MODE, _FULL_MODE = 1, 2, 3

# Group 1 (bumps and wheel drops, wall, four cliffs, virtual wall, overcurrents, dirt, unused), group 3 (charging state, voltage, current,
# temperature, charge, capacity), encoder counts left and right, charging sources, mode. None of these numbers is an opcode, so that a
# query which lost its first byte does nothing: packet 7, asked for by itself, would then be the reset of the robot.
_PACKETS = (1, 3, 43, 44, 34, 35)
_LAYOUT = struct.Struct(">10BBHhbHH2h2B")

_BUMPS = (("bumper left", 0b0010), ("bumper right", 0b0001), ("wheel drop left", 0b1000), ("wheel drop right", 0b0100))
_CLIFFS = ("cliff left", "cliff front left", "cliff front right", "cliff right")


class _Packets(NamedTuple):
    """The values of all packets, in the order in which they are asked for."""

    bumps: int
    wall: int
    cliff_left: int
    cliff_front_left: int
    cliff_front_right: int
    cliff_right: int
    virtual_wall: int
    overcurrents: int
    dirt: int
    unused: int
    charging_state: int
    voltage_mv: int
    current_ma: int
    temperature_c: int
    charge_mah: int
    capacity_mah: int
    left_ticks: int
    right_ticks: int
    charging_sources: int
    mode: int

    @property
    def cliffs(self) -> tuple[int, int, int, int]:
        return self.cliff_left, self.cliff_front_left, self.cliff_front_right, self.cliff_right

    def is_possible(self) -> bool:
        """Tell whether every value lies within its packet's range."""
        switches = max(self.wall, self.virtual_wall, *self.cliffs) <= 1 and self.bumps <= 15 and self.overcurrents <= 31
        charging = self.charging_state <= 5 and self.charging_sources <= 3
        return switches and charging and self.mode in (_PASSIVE_MODE, _SAFE_MODE, _FULL_MODE)

    def hazard(self) -> str:
        """Return which sensors say that the robot must not drive on."""
        touched = [name for name, bit in _BUMPS if self.bumps & bit]
        return ", ".join(touched + [name for name, seen in zip(_CLIFFS, self.cliffs, strict=True) if seen])


class Create2:
    """The language of one robot."""

    @property
    def traits(self) -> Traits:
        """Return what never changes about it; its unit of speed is 1 mm/s at the rim of a wheel."""
        return Traits(
            name="Create 2",
            ticks_per_revolution=TICKS_PER_REVOLUTION,
            counter_bits=16,
            unit_rad_s=1e-3 / WHEEL_RADIUS_M,
            max_units=_MAX_MM_S,
            stops_by_itself_s=None,
        )

    def greeting(self) -> tuple[bytes, ...]:
        """Return the end of whatever was half said, start and safe, with the pause that a change of mode wants, and a first query."""
        return self.resync() + bytes([START]), bytes([SAFE]), self.request()

    def recognises(self, sent: bytes, received: bytes) -> bool:
        """Tell whether an answer to the query has come."""
        return self.answer(sent, received).sample is not None

    def command(self, left: int, right: int) -> bytes:
        """Return Drive Direct with both speeds [mm/s]; the right wheel comes first."""
        return struct.pack(">B2h", DRIVE_DIRECT, right, left)

    def request(self) -> bytes:
        """Return the query of all packets."""
        return bytes([QUERY_LIST, len(_PACKETS), *_PACKETS])

    def resync(self) -> bytes:
        """Return zeros, which no command begins with: they end what it takes for the rest of a command whose bytes were lost."""
        return bytes(len(_PACKETS))

    def answer(self, sent: bytes, received: bytes) -> Answer:
        """Return what the packets say, behind an echo if there is one."""
        refused: tuple[str, ...] = ()
        if received[:1] == sent[:1]:  # no answer begins like that: 15 is the highest first byte
            received, refused = received[len(sent) :], (ECHO,)
        if len(received) < _LAYOUT.size:
            return Answer(refused=refused)
        packets = _Packets(*_LAYOUT.unpack(received[: _LAYOUT.size]))
        if len(received) > _LAYOUT.size or not packets.is_possible():
            return Answer(refused=(*refused, GARBLED), is_over=True)
        return Answer(_sample(packets), refused)


def _sample(packets: _Packets) -> Sample:
    """Return what packets mean. A robot that is not in safe mode is brought back to it as soon as nothing stands against that."""
    trouble, hazard = "", packets.hazard()
    remedy = b"" if packets.mode == _SAFE_MODE or packets.charging_sources or hazard else bytes([SAFE])
    if packets.charging_sources:
        trouble = "wheels: Create 2 is on its charger"
    elif packets.mode == _PASSIVE_MODE:
        trouble, hazard = "wheels: Create 2 has left safe mode", hazard or "Create 2 stopped by itself"
    battery = min(packets.charge_mah / packets.capacity_mah, 1.0) if packets.capacity_mah else None
    return Sample((packets.left_ticks, packets.right_ticks), trouble, hazard, battery, remedy)
