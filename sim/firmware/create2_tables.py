"""The iRobot Create 2 Open Interface as its specification lists it: opcodes, modes, sensor packets and groups of packets.

Source: "iRobot Create 2 Open Interface (OI) Specification based on the iRobot Roomba 600". All numbers of more than one byte travel with
their high byte first.
"""

from __future__ import annotations

from typing import Final, NamedTuple

OFF, PASSIVE, SAFE, FULL = range(4)  # packet 35

BAUD = 115200
STREAM_S = 0.015
STREAM_HEADER = 19
FASTEST_MM_S = 500
WIDEST_MM = 2000  # of radii
ROBOT_RADIUS_M = 0.17
FULL_PWM = 255
STRAIGHT = (0x7FFF, -0x8000)  # radii that mean none
ON_THE_SPOT = {-1: -1, 1: 1}  # radii that mean turning clockwise, and counter-clockwise

# fmt: off
RESET, START, BAUD_RATE, MODE_SAFE, MODE_FULL, POWER = 7, 128, 129, 131, 132, 133
DRIVE, DRIVE_DIRECT, DRIVE_PWM = 137, 145, 146
SENSORS, STREAM, QUERY_LIST, PAUSE_RESUME, STOP = 142, 148, 149, 150, 173
CLEANING = (134, 135, 136, 143)  # spot, clean, max, seek dock: the robot then drives as it likes, which is not shown here
BAUD_CODES = (300, 600, 1200, 2400, 4800, 9600, 14400, 19200, 28800, 38400, 57600, 115200)  # of opcode 129

# Opcode: data bytes behind it. Where the number of them is told by one of them, that is how many stand before the rest.
DATA_BYTES: Final = {
    RESET: 0, START: 0, BAUD_RATE: 1, MODE_SAFE: 0, MODE_FULL: 0, POWER: 0, 134: 0, 135: 0, 136: 0, DRIVE: 4, 138: 1, 139: 3, 141: 1,
    SENSORS: 1, 143: 0, 144: 3, DRIVE_DIRECT: 4, DRIVE_PWM: 4, PAUSE_RESUME: 1, 162: 2, 163: 4, 164: 4, 165: 1, 167: 15, 168: 3, STOP: 0,
}
COUNTED: Final = {STREAM: 1, QUERY_LIST: 1}  # opcode: bytes for each that is counted by its first data byte
SONG, SONG_HEAD, SONG_NOTE = 140, 2, 2  # number and length, then two bytes for each note
# fmt: on


class Packet(NamedTuple):
    """One sensor packet."""

    size: int  # [bytes]
    signed: bool = False
    at_rest: int = 0  # what it reads while nothing is done to the robot


_FLAG, _WORD, _SIGNED = Packet(1), Packet(2), Packet(2, signed=True)

BUMPS_AND_DROPS, CLIFFS, OVERCURRENTS, CHARGERS = 7, range(9, 13), 14, 34
BUMP_RIGHT, BUMP_LEFT, DROP_RIGHT, DROP_LEFT = 1, 2, 4, 8  # bits of packet 7
HOME_BASE, INTERNAL_CHARGER = 2, 1  # bits of packet 34
DISTANCE, ANGLE, MODE, STREAMED = 19, 20, 35, 38
VELOCITY, RADIUS, RIGHT_VELOCITY, LEFT_VELOCITY, LEFT_COUNTS, RIGHT_COUNTS = 39, 40, 41, 42, 43, 44

PACKETS: Final = {
    BUMPS_AND_DROPS: _FLAG,
    8: _FLAG,  # wall
    9: _FLAG,  # cliff left
    10: _FLAG,  # cliff front left
    11: _FLAG,  # cliff front right
    12: _FLAG,  # cliff right
    13: _FLAG,  # virtual wall
    OVERCURRENTS: _FLAG,
    15: _FLAG,  # dirt
    16: _FLAG,  # unused
    17: _FLAG,  # infrared character, omni
    18: _FLAG,  # buttons
    DISTANCE: _SIGNED,  # since it was last asked for [mm]
    ANGLE: _SIGNED,  # since it was last asked for, counter-clockwise [degrees]
    21: _FLAG,  # charging state
    22: Packet(2, at_rest=16200),  # voltage [mV]
    23: Packet(2, signed=True, at_rest=-280),  # current [mA]
    24: Packet(1, signed=True, at_rest=25),  # temperature [degrees Celsius]
    25: Packet(2, at_rest=2300),  # battery charge [mAh]
    26: Packet(2, at_rest=2696),  # battery capacity [mAh]
    27: _WORD,  # wall signal
    28: Packet(2, at_rest=2800),  # cliff left signal
    29: Packet(2, at_rest=2800),
    30: Packet(2, at_rest=2800),
    31: Packet(2, at_rest=2800),  # cliff right signal
    32: _FLAG,  # unused
    33: _WORD,  # unused
    CHARGERS: _FLAG,
    MODE: _FLAG,
    36: _FLAG,  # song number
    37: _FLAG,  # song playing
    STREAMED: _FLAG,  # how many packets
    VELOCITY: _SIGNED,  # requested [mm/s]
    RADIUS: _SIGNED,  # requested [mm]
    RIGHT_VELOCITY: _SIGNED,  # requested [mm/s]
    LEFT_VELOCITY: _SIGNED,  # requested [mm/s]
    LEFT_COUNTS: _SIGNED,
    RIGHT_COUNTS: _SIGNED,
    45: _FLAG,  # light bumper
    46: _WORD,  # light bump left signal
    47: _WORD,
    48: _WORD,
    49: _WORD,
    50: _WORD,
    51: _WORD,  # light bump right signal
    52: _FLAG,  # infrared character, left
    53: _FLAG,  # infrared character, right
    54: _SIGNED,  # left motor current [mA]
    55: _SIGNED,  # right motor current [mA]
    56: _SIGNED,  # main brush motor current [mA]
    57: _SIGNED,  # side brush motor current [mA]
    58: _FLAG,  # stasis
}

GROUPS: Final = {
    0: range(7, 27),
    1: range(7, 17),
    2: range(17, 21),
    3: range(21, 27),
    4: range(27, 35),
    5: range(35, 43),
    6: range(7, 43),
    100: range(7, 59),
    101: range(43, 59),
    106: range(46, 52),
    107: range(54, 59),
}


def members(packet: int) -> range:
    """Return the packets of a group, or of a single packet; none where there is no such packet."""
    return GROUPS.get(packet, range(packet, packet + 1) if packet in PACKETS else range(0))


def packed(packet: int, value: int) -> bytes:
    """Return a packet's value as it travels: what is too large wraps, as it does in the robot."""
    return (value % (1 << 8 * PACKETS[packet].size)).to_bytes(PACKETS[packet].size, "big")
