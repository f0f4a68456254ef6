"""The ROSArduinoBridge firmware on an Arduino with two motors and two encoders.

Source: github.com/hbrobotics/ros_arduino_bridge, ros_arduino_firmware/src/libraries/ROSArduinoBridge: `commands.h` (letters),
`ROSArduinoBridge.ino` (parser, answers, 30 Hz loop, auto-stop) and `diff_controller.h` (speed controller).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

from sim.firmware.board import Motors
from sim.firmware.speed_controller import FULL_PWM, Gains, SpeedController
from sim.world.drive import Wheels

BAUD = 57600
FRAME_S = 0.033  # 1000 / 30 whole milliseconds
AUTO_STOP_S = 2.0

_CR, _SPACE = 13, 32
_LONGEST_ARGUMENT = 31
_NEVER = math.inf


class ArduinoRig(NamedTuple):
    """What the firmware does not know of its robot."""

    encoder_ticks_per_rev: float = 1440.0
    full_rad_s: float = 12.0  # of a wheel at full duty
    boot_s: float = 1.0  # until the boot loader has given up waiting for a new program


class RosArduinoBridge:
    """The firmware as a machine. The Arduino restarts when somebody opens its line, as the common boards do."""

    baud = BAUD

    def __init__(self, rig: ArduinoRig, motors: Motors, now_s: float) -> None:
        self._rig, self._motors = rig, motors
        self.reboot(now_s)

    def opened(self, now_s: float) -> None:
        """Restart."""
        self.reboot(now_s)

    def reboot(self, now_s: float) -> None:
        """Begin anew, deaf until the boot loader is through, with standing motors and encoders at zero."""
        self._deaf_until_s = now_s + self._rig.boot_s
        self._next_frame_s, self._stop_at_s = self._deaf_until_s + FRAME_S, _NEVER
        self._gains, self._moving = Gains(), False
        self._left, self._right = SpeedController(), SpeedController()
        self._letter, self._arguments = "", ["", ""]
        self._field = 0  # which is being read: the letter, the first argument or the second
        self._duty(0, 0, now_s)
        self._booted, self._zero = False, self._ticks(now_s)

    def receive(self, byte: int, now_s: float) -> bytes:
        """Take a byte, as the firmware's parser does: a letter, arguments behind spaces, a CR, by which the command is carried out."""
        if now_s < self._deaf_until_s:
            return b""
        if byte == _CR:
            answer = self._carry_out(now_s)
            self._letter, self._arguments, self._field = "", ["", ""], 0
            return answer
        if byte == _SPACE:
            self._field = min(self._field + 1, 2)
        elif self._field == 0:
            self._letter = chr(byte)  # the last before the space: a line feed of the last command harms nobody
        elif len(self._arguments[self._field - 1]) < _LONGEST_ARGUMENT:
            self._arguments[self._field - 1] += chr(byte)
        return b""

    def turn(self, now_s: float) -> bytes:
        """Run the frames and the auto-stop that are due; the firmware says nothing unasked."""
        if not self._booted and now_s >= self._deaf_until_s:
            self._booted, self._zero = True, self._ticks(self._deaf_until_s)
        while (due_s := min(self._next_frame_s, self._stop_at_s)) <= now_s:
            if due_s == self._stop_at_s:
                self._duty(0, 0, due_s)
                self._moving, self._stop_at_s = False, _NEVER
            else:
                self._frame(due_s)
                self._next_frame_s += FRAME_S
        return b""

    def sense(self, sensor: int, value: int) -> None:
        """Refuse: nothing on this board is a sensor."""
        raise ValueError(f"a ROSArduinoBridge has no sensor {sensor}")

    def counts(self, now_s: float) -> tuple[int, int]:
        """Return both encoders' ticks since they were at zero, left first."""
        left, right = self._ticks(now_s)
        return _as_long(left - self._zero[0]), _as_long(right - self._zero[1])

    def _carry_out(self, now_s: float) -> bytes:
        command = COMMANDS.get(self._letter)
        first, second = self._arguments
        answer = command(self, first, second, now_s) if command else "Invalid Command"
        return f"{answer}\r\n".encode("ascii")

    def _frame(self, now_s: float) -> None:
        left, right = self.counts(now_s)
        if self._moving:
            self._duty(self._left.step(left, self._gains), self._right.step(right, self._gains), now_s)
        elif self._left.turned or self._right.turned:
            self._reset_controllers(now_s)

    def _reset_controllers(self, now_s: float) -> None:
        left, right = self.counts(now_s)
        self._left.reset(left)
        self._right.reset(right)

    def _duty(self, left: int, right: int, now_s: float) -> None:
        """Put both motors to a duty, -255 to 255, under which a free wheel comes to that part of its full speed."""
        left, right = (min(max(duty, -FULL_PWM), FULL_PWM) for duty in (left, right))
        full = self._rig.full_rad_s / FULL_PWM
        self._motors.command(Wheels(left * full, right * full), now_s)

    def _ticks(self, now_s: float) -> tuple[int, int]:
        left, right = self._motors.turning(now_s).angles_rad
        per_rad = self._rig.encoder_ticks_per_rev / (2.0 * math.pi)
        return math.floor(left * per_rad), math.floor(right * per_rad)

    def read_encoders(self, _first: str, _second: str, now_s: float) -> str:
        """`e`."""
        left, right = self.counts(now_s)
        return f"{left} {right}"

    def reset_encoders(self, _first: str, _second: str, now_s: float) -> str:
        """`r`."""
        self._zero = self._ticks(now_s)
        self._reset_controllers(now_s)
        return "OK"

    def motor_speeds(self, first: str, second: str, now_s: float) -> str:
        """`m LEFT RIGHT`, in ticks per frame; also what keeps the auto-stop away."""
        left, right = _as_int(first), _as_int(second)
        self._stop_at_s = now_s + AUTO_STOP_S
        self._moving = (left, right) != (0, 0)
        if not self._moving:
            self._duty(0, 0, now_s)
            self._reset_controllers(now_s)
        self._left.target_ticks, self._right.target_ticks = left, right
        return "OK"

    def motor_raw_pwm(self, first: str, second: str, now_s: float) -> str:
        """`o LEFT RIGHT`, duties past the speed controller."""
        self._stop_at_s = now_s + AUTO_STOP_S
        self._reset_controllers(now_s)
        self._moving = False
        self._duty(_as_int(first), _as_int(second), now_s)
        return "OK"

    def update_pid(self, first: str, _second: str, _now_s: float) -> str:
        """`u KP:KD:KI:KO`."""
        told = [_as_int(gain) for gain in first.split(":") if gain][:4]
        self._gains = Gains(*told, *self._gains[len(told) :])
        return "OK"


def _says(text: str) -> Callable[[RosArduinoBridge, str, str, float], str]:
    return lambda _board, _first, _second, _now_s: text


# Everything that the firmware understands with a base and without servos; pins and sonars are there, and nothing is connected to them.
# fmt: off
COMMANDS: dict[str, Callable[[RosArduinoBridge, str, str, float], str]] = {
    "a": _says("0"),  # ANALOG_READ pin
    "b": _says(str(BAUD)),  # GET_BAUDRATE
    "c": _says("OK"),  # PIN_MODE pin mode
    "d": _says("0"),  # DIGITAL_READ pin
    "e": RosArduinoBridge.read_encoders,
    "m": RosArduinoBridge.motor_speeds,
    "o": RosArduinoBridge.motor_raw_pwm,
    "p": _says("0"),  # PING pin [cm]
    "r": RosArduinoBridge.reset_encoders,
    "u": RosArduinoBridge.update_pid,
    "w": _says("OK"),  # DIGITAL_WRITE pin level
    "x": _says("OK"),  # ANALOG_WRITE pin duty
}
# fmt: on


def _as_int(text: str) -> int:
    """Return what C's atoi makes of a text, in the 16 bits of an Arduino's int: the leading digits, 0 where there are none."""
    text = text.strip()
    digits = text[1:] if text[:1] in ("-", "+") else text
    length = next((index for index, character in enumerate(digits) if not ("0" <= character <= "9")), len(digits))
    value = int(digits[:length] or "0") * (-1 if text[:1] == "-" else 1)
    return (value + 0x8000) % 0x10000 - 0x8000


def _as_long(value: int) -> int:
    return (value + 0x8000_0000) % 0x1_0000_0000 - 0x8000_0000
