"""An emulated board in place of a robot's bus wheels: the world turns as its motors do, and its encoders count what turned there."""

from __future__ import annotations

import time

from protocol import topics
from protocol.bus import Bus
from protocol.messages import WheelCommand
from sim.firmware.world_motors import WorldMotors
from sim.world.drive import Drive, Wheels


class WorldLink:
    """One robot's wheels on the world's router. The world stamps in wall time (`python -m sim --clock wall`)."""

    def __init__(self, bus: Bus, robot: str, drive: Drive, command_delay_s: float) -> None:
        self._commands = bus.publisher(topics.WHEEL_COMMAND, robot=robot)
        self._readings = bus.inbox(topics.WHEEL_READINGS, robot=robot)
        self._wall_ahead_s = time.time() - time.monotonic()
        self.motors = WorldMotors(drive, command_delay_s, self._send, time.monotonic())
        bus.announce(topics.WHEELS_READY, robot=robot)

    def turn(self, _now_s: float) -> None:
        """Take what the world has told of the wheels."""
        for readings in self._readings.take():
            if len(readings.stamps_ns.array()):
                left, right = readings.angles_rad.array()[-1].tolist()
                self.motors.told(1e-9 * float(readings.stamps_ns.array()[-1]) - self._wall_ahead_s, Wheels(left, right))

    def _send(self, speeds_rad_s: Wheels) -> None:
        left, right = speeds_rad_s
        self._commands.put(WheelCommand(left_rad_s=left, right_rad_s=right))
