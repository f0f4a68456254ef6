"""The doctor on the wheels: port, firmware, and whether the encoders turn when the robot is pushed. It never drives them."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import closing

import numpy as np

from agent.config import AgentConfig, BusWheelSettings
from agent.doctor.finding import Finding, bad, good, warning
from agent.drivers.firmwares import firmware_of
from agent.drivers.serial_wheels import SerialWheels
from protocol.geometry import Array

FIND_S = 6.0  # a board may restart when its port is opened
PUSH_S = 15.0
PUSHED_RAD = 0.5  # of each wheel: a centimetre or two
_TURN_S = 0.05
_FEW = 5  # readings


def examine_wheels(config: AgentConfig, ask: Callable[[str], None] | None) -> list[Finding]:
    """Return how the robot's wheels fare, where they are on a line that nobody else has; `ask` tells a person to push the robot.

    Without `ask` nobody is asked to.
    """
    settings = config.wheels
    if isinstance(settings, BusWheelSettings):
        return [good("wheels", f"in a simulated or recorded world, at {settings.endpoint}")]
    firmware = firmware_of(settings)
    limit_rad_s = config.drive.max_wheel_rad_s
    with closing(SerialWheels(settings.port, settings.baud, firmware, limit_rad_s, lambda local_ns: local_ns)) as wheels:
        found = _angles_after(wheels, FIND_S, lambda angles: len(angles) >= _FEW)
        findings = judge(settings.port, firmware.traits.name, len(found), wheels)
        if ask is not None and found:
            ask(f"push the robot a hand's breadth forward, within {PUSH_S:g} s")
            pushed = _angles_after(wheels, PUSH_S, lambda angles: bool(np.all(np.abs(_turned(angles)) > PUSHED_RAD)))
            findings.append(judge_push(_turned([found[-1], *pushed])))
    return findings


def judge(port: str, firmware: str, readings: int, wheels: SerialWheels) -> list[Finding]:
    """Return how wheels at a port fare that gave so many readings."""
    condition = wheels.condition
    if not readings or condition.trouble:
        cause = condition.trouble.removeprefix("wheels: ") or "its encoders do not answer"
        next_step = f"check plug and power, that {port} is the board's port (ls -l /dev/serial/by-id), and driver and baud in [wheels]"
        return [bad("wheels", f"{firmware} at {port} gives no readings", cause, next_step)]
    findings = [good("wheels", f"{firmware} at {port} answers{_charge(condition.battery)}"), _stop_by_itself(wheels.stops_by_itself_s)]
    if condition.hazard:
        findings.append(bad("sensors", condition.hazard, "the wheels are held while it says so", "set the robot free on the floor"))
    return findings


def judge_push(turned_rad: Array) -> Finding:
    """Return what both encoders counted of a push forward, (2,) [rad: left, right]."""
    seen = f"turned {turned_rad[0]:+.2f} and {turned_rad[1]:+.2f} rad when pushed"
    for side, angle_rad in zip(("left", "right"), turned_rad, strict=True):
        if abs(angle_rad) <= PUSHED_RAD:
            return bad("encoders", seen, f"the {side} one does not count", "check its cable and its supply; was the robot pushed?")
        if angle_rad < 0.0:
            return bad("encoders", seen, f"the {side} one counts backwards", "swap its two signal wires, or its sign in the firmware")
    return good("encoders", seen)


def _stop_by_itself(after_s: float | None) -> Finding:
    if after_s is None:
        next_step = "keep a hand near, or add a switch that cuts the motors; bumpers still hold it while the line is up"
        return warning("pulled line", "its wheels would go on as they are", "this hardware has no stop of its own", next_step)
    return good("pulled line", f"the board stops by itself after {after_s:g} s")


def _charge(battery: float | None) -> str:
    return "" if battery is None else f", battery at {100.0 * battery:.0f} %"


def _angles_after(wheels: SerialWheels, limit_s: float, is_enough: Callable[[list[Array]], bool]) -> list[Array]:
    """Return the wheels' angles, each (2,) [rad], until they are enough or the time is over."""
    angles: list[Array] = []
    until_s = time.monotonic() + limit_s
    while time.monotonic() < until_s and not is_enough(angles):
        angles.extend(row for readings in wheels.read(_TURN_S) for row in readings.angles_rad.array())
    return angles


def _turned(angles: list[Array]) -> Array:
    return angles[-1] - angles[0] if angles else np.zeros(2)
