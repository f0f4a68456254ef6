"""Which language the motor controller of a configuration file speaks, by the name of its driver."""

from __future__ import annotations

from agent.config import Create2Settings, RosArduinoBridgeSettings
from agent.drivers.create2 import Create2
from agent.drivers.firmware import Firmware
from agent.drivers.ros_arduino_bridge import RosArduinoBridge


def firmware_of(wheels: RosArduinoBridgeSettings | Create2Settings) -> Firmware:
    """Return the language of the controller at a serial port."""
    match wheels:
        case RosArduinoBridgeSettings():
            return RosArduinoBridge(wheels.ticks_per_revolution, wheels.pid_rate_hz, wheels.baud, wheels.pid, wheels.settle_s)
        case Create2Settings():
            return Create2()
