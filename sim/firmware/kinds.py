"""The devices that can stand at the end of a serial line, by name."""

from __future__ import annotations

from collections.abc import Mapping

from sim.firmware import create2_tables, ros_arduino_bridge
from sim.firmware.board import Maker
from sim.firmware.create2 import Create2, Create2Rig
from sim.firmware.other_devices import GpsReceiver
from sim.firmware.ros_arduino_bridge import ArduinoRig, RosArduinoBridge

ROS_ARDUINO_BRIDGE, CREATE2 = "ros_arduino_bridge", "create2"


def makers(arduino: ArduinoRig, create2: Create2Rig) -> Mapping[str, Maker]:
    """Return how each device is made; a GPS receiver comes at the speed of the board in whose place it is."""
    return {
        ROS_ARDUINO_BRIDGE: lambda motors, now_s: RosArduinoBridge(arduino, motors, now_s),
        CREATE2: lambda motors, now_s: Create2(create2, motors, now_s),
        "gps_57600": lambda _motors, now_s: GpsReceiver(ros_arduino_bridge.BAUD, now_s),
        "gps_115200": lambda _motors, now_s: GpsReceiver(create2_tables.BAUD, now_s),
    }
