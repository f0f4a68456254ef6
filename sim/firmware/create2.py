"""An iRobot Create 2 as its Open Interface shows it: modes, drive commands, sensor packets and streams.

Source: as in `create2_tables.py`; sections "Modes", "Actuator Commands", "Input Commands".
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

from sim.firmware import create2_drive
from sim.firmware import create2_tables as oi
from sim.firmware.board import Motors
from sim.firmware.open_interface import OpcodeReader, signed_words
from sim.world.drive import STILL, Wheels

_BOOT_TEXT = b"bl-start\r\nSTR730\r\n"  # how it begins to tell of its boot loader


class Create2Rig(NamedTuple):
    """What the firmware knows of its own wheels; a robot of another size that speaks the same is told here."""

    wheel_base_m: float = 0.235
    wheel_radius_m: float = 0.036
    encoder_ticks_per_rev: float = 508.8
    boot_s: float = 5.0


class Create2:
    """The robot as a machine. Opening its line does nothing to it."""

    def __init__(self, rig: Create2Rig, motors: Motors, now_s: float) -> None:
        self._rig, self._motors = rig, motors
        self._sensed: dict[int, int] = {number: packet.at_rest for number, packet in oi.PACKETS.items()}
        self._deaf_until_s, self._booted = now_s, False
        self._begin(now_s)

    @property
    def baud(self) -> int:
        """The speed of its serial line, which opcode 129 sets until the next boot [bit/s]."""
        return self._baud

    def opened(self, now_s: float) -> None:
        """Go on as before."""

    def reboot(self, now_s: float) -> None:
        """Begin anew, deaf until it has booted, off, with encoders at zero."""
        self._deaf_until_s = now_s + self._rig.boot_s
        self._begin(now_s)

    def receive(self, byte: int, now_s: float) -> bytes:
        """Take a byte, and carry out the command that it completes."""
        if now_s < self._deaf_until_s:
            return b""
        command = self._reader.add(byte)
        return self._carry_out(command.opcode, command.data, now_s) if command else b""

    def turn(self, now_s: float) -> bytes:
        """See whether it is still safe to drive, and return the streams that are due."""
        if not self._booted and now_s >= self._deaf_until_s:
            self._booted = True
            self._zero = self._motors.turning(self._deaf_until_s).angles_rad
        self._look_out(now_s)
        told = b""
        while self._streaming and self._next_stream_s <= now_s:
            told += self._stream(now_s)
            self._next_stream_s += oi.STREAM_S
        return told

    def sense(self, sensor: int, value: int) -> None:
        """Let a packet read a value from now on; raises ValueError where there is no such packet, or the robot itself tells it."""
        if sensor not in oi.PACKETS or sensor in (*range(oi.DISTANCE, oi.ANGLE + 1), *range(oi.MODE, oi.RIGHT_COUNTS + 1)):
            raise ValueError(f"packet {sensor} of a Create 2 is none that something from outside changes")
        self._sensed[sensor] = value

    def _begin(self, now_s: float) -> None:
        self._reader = OpcodeReader()
        self._mode, self._baud = oi.OFF, oi.BAUD
        self._asked: tuple[int, ...] = ()  # packets of the stream
        self._streaming, self._next_stream_s = False, now_s
        self._requested: dict[int, int] = dict.fromkeys((oi.VELOCITY, oi.RADIUS, oi.RIGHT_VELOCITY, oi.LEFT_VELOCITY), 0)
        self._command(STILL, now_s)
        self._booted = False
        self._zero = self._motors.turning(now_s).angles_rad
        self._told = dict.fromkeys((oi.DISTANCE, oi.ANGLE), self._zero)  # the angles at which each was last told

    def _carry_out(self, opcode: int, data: bytes, now_s: float) -> bytes:
        if opcode == oi.RESET:
            self.reboot(now_s)
            return _BOOT_TEXT
        if opcode != oi.START and self._mode == oi.OFF:
            return b""
        if opcode in _MODE_AFTER:
            self._enter(_MODE_AFTER[opcode], now_s)
        elif opcode in _ACTUATORS and self._mode in (oi.SAFE, oi.FULL):
            _ACTUATORS[opcode](self, signed_words(data), now_s)
        elif opcode in _INPUTS:
            return _INPUTS[opcode](self, data, now_s)
        return b""

    def _enter(self, mode: int, now_s: float) -> None:
        self._mode = mode
        self._command(STILL, now_s)
        self._look_out(now_s)
        if mode == oi.OFF:
            self._streaming = False

    def _look_out(self, now_s: float) -> None:
        """In Safe mode, stop and fall back to Passive at a wheel drop, a charger, or a cliff ahead."""
        if self._mode != oi.SAFE:
            return
        dropped = self._sensed[oi.BUMPS_AND_DROPS] & (oi.DROP_LEFT | oi.DROP_RIGHT)
        nearer = create2_drive.brings_cliff_nearer(self._rims_mm_s, self._rig.wheel_base_m)
        at_cliff = nearer and any(self._sensed[cliff] for cliff in oi.CLIFFS)
        if dropped or at_cliff or self._sensed[oi.CHARGERS]:
            self._enter(oi.PASSIVE, now_s)

    def _drive_direct(self, words: tuple[int, ...], now_s: float) -> None:
        right, left = words
        self._requested.update({oi.RIGHT_VELOCITY: right, oi.LEFT_VELOCITY: left})
        self._command(create2_drive.direct(right, left), now_s)

    def _drive_pwm(self, words: tuple[int, ...], now_s: float) -> None:
        right, left = words
        self._command(create2_drive.pwm(right, left), now_s)

    def _drive(self, words: tuple[int, ...], now_s: float) -> None:
        speed, radius = words
        self._requested.update({oi.VELOCITY: speed, oi.RADIUS: radius})
        self._command(create2_drive.about_radius(speed, radius, self._rig.wheel_base_m), now_s)

    def _command(self, rims_mm_s: Wheels, now_s: float) -> None:
        self._rims_mm_s = rims_mm_s
        rad = 1e-3 / self._rig.wheel_radius_m
        self._motors.command(Wheels(rims_mm_s.left * rad, rims_mm_s.right * rad), now_s)

    def _set_baud(self, data: bytes, _now_s: float) -> bytes:
        self._baud = oi.BAUD_CODES[data[0]] if data[0] < len(oi.BAUD_CODES) else self._baud
        return b""

    def _sensors(self, data: bytes, now_s: float) -> bytes:
        return b"".join(oi.packed(packet, self._read(packet, now_s)) for packet in oi.members(data[0]))

    def _query_list(self, data: bytes, now_s: float) -> bytes:
        return b"".join(self._sensors(bytes((packet,)), now_s) for packet in data[1:])

    def _ask_stream(self, data: bytes, now_s: float) -> bytes:
        self._asked = tuple(data[1:])
        self._streaming, self._next_stream_s = bool(self._asked), now_s + oi.STREAM_S
        return b""

    def _pause_resume(self, data: bytes, now_s: float) -> bytes:
        self._streaming, self._next_stream_s = bool(data[0] and self._asked), now_s + oi.STREAM_S
        return b""

    def _stream(self, now_s: float) -> bytes:
        """Return [19][number of bytes][packet][value]...[checksum], which sum up to 0 in their low byte."""
        body = b"".join(bytes((packet,)) + self._sensors(bytes((packet,)), now_s) for packet in self._asked)
        told = bytes((oi.STREAM_HEADER, len(body) % 256)) + body
        return told + bytes((-sum(told) % 256,))

    def _read(self, packet: int, now_s: float) -> int:
        if packet in (oi.DISTANCE, oi.ANGLE):
            return self._way(packet, now_s)
        if packet in (oi.LEFT_COUNTS, oi.RIGHT_COUNTS):
            wheel = packet - oi.LEFT_COUNTS
            turned_rad = self._motors.turning(now_s).angles_rad[wheel] - self._zero[wheel]
            return math.floor(turned_rad * self._rig.encoder_ticks_per_rev / (2.0 * math.pi))
        own = {oi.MODE: self._mode, oi.STREAMED: len(self._asked), **self._requested}
        return own.get(packet, self._sensed[packet])

    def _way(self, packet: int, now_s: float) -> int:
        """Return the way [mm] or the turn [degrees] since it was last asked for."""
        before, self._told[packet] = self._told[packet], self._motors.turning(now_s).angles_rad
        left_m, right_m = (self._rig.wheel_radius_m * (now - then) for now, then in zip(self._told[packet], before, strict=True))
        if packet == oi.DISTANCE:
            return round(500.0 * (left_m + right_m))
        return round(math.degrees((right_m - left_m) / self._rig.wheel_base_m))


_MODE_AFTER = {
    oi.START: oi.PASSIVE,
    oi.MODE_SAFE: oi.SAFE,
    oi.MODE_FULL: oi.FULL,
    oi.POWER: oi.PASSIVE,
    oi.STOP: oi.OFF,
    **dict.fromkeys(oi.CLEANING, oi.PASSIVE),
}
_ACTUATORS: dict[int, Callable[[Create2, tuple[int, ...], float], None]] = {
    oi.DRIVE: Create2._drive,
    oi.DRIVE_DIRECT: Create2._drive_direct,
    oi.DRIVE_PWM: Create2._drive_pwm,
}
_INPUTS: dict[int, Callable[[Create2, bytes, float], bytes]] = {
    oi.BAUD_RATE: Create2._set_baud,
    oi.SENSORS: Create2._sensors,
    oi.QUERY_LIST: Create2._query_list,
    oi.STREAM: Create2._ask_stream,
    oi.PAUSE_RESUME: Create2._pause_resume,
}
