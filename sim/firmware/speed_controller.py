"""The speed controller of the ROSArduinoBridge firmware: one wheel, whole numbers, a frame at a time (its diff_controller.h)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

FULL_PWM = 255


class Gains(NamedTuple):
    """What `u` sets: proportional, derivative and integral gain, and what their sum is divided by."""

    kp: int = 20
    kd: int = 12
    ki: int = 0
    ko: int = 50


@dataclass
class SpeedController:
    """Adds to the motor's duty what a wheel lacks in ticks per frame. `reset` comes before the first step of every drive."""

    target_ticks: int = 0  # per frame
    _counted: int = 0  # at the last frame [ticks]
    _turned: int = 0  # in the last frame [ticks]
    _integral: int = 0
    _pwm: int = 0

    @property
    def turned(self) -> bool:
        """Whether the wheel turned in the last frame."""
        return self._turned != 0

    def reset(self, counted: int) -> None:
        """Begin anew at a count."""
        self.target_ticks, self._counted, self._turned, self._integral, self._pwm = 0, counted, 0, 0, 0

    def step(self, counted: int, gains: Gains) -> int:
        """Return the duty for the next frame, -255 to 255."""
        turned = counted - self._counted
        error = self.target_ticks - turned
        change = _divided(gains.kp * error - gains.kd * (turned - self._turned) + self._integral, gains.ko)
        pwm = min(max(self._pwm + change, -FULL_PWM), FULL_PWM)
        if abs(pwm) < FULL_PWM:  # no winding up
            self._integral += gains.ki * error
        self._counted, self._turned, self._pwm = counted, turned, pwm
        return pwm


def _divided(number: int, by: int) -> int:
    """Divide as C does, towards zero; what is divided by nothing the processor leaves at -1."""
    return int(number / by) if by else -1
