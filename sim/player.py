"""Plays a recording to the robots' drivers, on the world's own router."""

from __future__ import annotations

from pathlib import Path
from typing import Self

from protocol import topics
from protocol.bus import Bus
from protocol.fields import Packed
from protocol.messages import Frame, WheelReadings
from sim.recording import Recording, Step, WheelRows
from sim.world_router import WorldRouter


class Player(WorldRouter):
    """Stands where the robots' metal stands: hands out what cameras and wheels told, one step whenever it is asked to."""

    def __init__(self, recording: Recording, world: Bus) -> None:
        self._names = recording.names
        super().__init__(world)
        self._frames = {name: world.publisher(topics.FRAME, robot=name) for name in self._names}
        self._wheels = {name: world.publisher(topics.WHEEL_READINGS, robot=name) for name in self._names}

    @classmethod
    def open(cls, recording: Recording, site: str) -> Self:
        """Open the world's router on a free loopback port; raises LinkError where that cannot be had."""
        return cls(recording, Bus.open_router(site))

    def wait_until_ready(self, timeout_s: float) -> None:
        """Return when every robot's camera and wheel drivers listen; raises LinkError with the missing ones."""
        for token in (topics.CAMERA_READY, topics.WHEELS_READY):
            self._world.presence(token).wait_for(self._names, timeout_s)

    def release(self, step: Step) -> None:
        """Publish a step: to every robot the wheel readings up to its stamp, then a frame to those whose cameras fired."""
        for name, rows in step.wheels.items():
            self._wheels[name].put(wheel_readings(step.stamp_ns, rows))
        for name, picture in step.pictures.items():
            self._frames[name].put(stored_frame(step.stamp_ns, picture))


def wheel_readings(until_ns: int, rows: WheelRows) -> WheelReadings:
    """Return the message that tells these readings, and that there are no others up to `until_ns`."""
    return WheelReadings(until_ns=until_ns, stamps_ns=Packed.of(rows.stamps_ns, "i8"), angles_rad=Packed.of(rows.angles_rad, "f8"))


def stored_frame(stamp_ns: int, picture: Path) -> Frame:
    """Return a picture as its stored bytes, or, where its file cannot be read, the message that it is missing."""
    try:
        data = picture.read_bytes()
    except OSError:
        return Frame(stamp_ns=stamp_ns, encoding="missing", shape=(0, 0), data=b"")
    return Frame(stamp_ns=stamp_ns, encoding="jpeg", shape=(0, 0), data=data)
