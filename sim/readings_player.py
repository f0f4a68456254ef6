"""Plays what robots without cameras were told to their drivers, on the world's own router."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Self

from protocol import topics
from protocol.bus import Bus
from protocol.fields import Packed
from protocol.messages import SensorReadings
from sim.mrclam import Readings, ReadingsStep
from sim.world_router import WorldRouter


class ReadingsPlayer(WorldRouter):
    """Hands out readings, one step whenever it is asked to."""

    def __init__(self, robots: Sequence[str], world: Bus) -> None:
        self._robots = robots
        super().__init__(world)
        self._readings = {name: world.publisher(topics.SENSOR_READINGS, robot=name) for name in robots}

    @classmethod
    def open(cls, robots: Sequence[str], site: str) -> Self:
        """Open the world's router on a free loopback port; raises LinkError where that cannot be had."""
        return cls(robots, Bus.open_router(site))

    def wait_until_ready(self, timeout_s: float) -> None:
        """Return when every robot's driver listens; raises LinkError with the missing ones."""
        self._world.presence(topics.SENSORS_READY).wait_for(self._robots, timeout_s)

    def release(self, step: ReadingsStep) -> None:
        """Publish a step: to every robot in it what it was told up to its stamp."""
        for name, readings in step.readings.items():
            self._readings[name].put(sensor_readings(step.stamp_ns, readings))


def sensor_readings(until_ns: int, readings: Readings) -> SensorReadings:
    """Return the message that tells these readings, and that there are no others up to `until_ns`."""
    return SensorReadings(
        until_ns=until_ns,
        twist_stamps_ns=Packed.of(readings.twist_stamps_ns, "i8"),
        twists=Packed.of(readings.twists, "f8"),
        sighting_stamps_ns=Packed.of(readings.sighting_stamps_ns, "i8"),
        sightings=Packed.of(readings.sightings, "f8"),
        identities=readings.identities,
    )
