"""The robots' metal on the world's own router: what goes out to their drivers, what comes in from them, and who is there."""

from __future__ import annotations

import logging
import math
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Literal, NamedTuple

from protocol import topics
from protocol.bus import Bus
from protocol.fields import Packed, pose_tuple
from protocol.messages import BodyTruth, Frame, WheelCommand, WheelReadings, WorldTime, WorldTruth
from sim.world.cameras import Picture
from sim.world.world import EncoderRows, Moment

_TURN_S = 0.2  # the longest sleep while somebody is missing
_NAME_MISSING_S = 10.0

_log = logging.getLogger(__name__)


class ArrivedCommand(NamedTuple):
    """A wheel command, and when it came."""

    robot: str
    command: WheelCommand
    arrived_s: float  # [monotonic clock]


class RobotLinks:
    """The drivers of all robots, on one bus. Where `when_full` is "wait", one that is stuck holds up all; else it loses what it leaves."""

    def __init__(
        self, bus: Bus, robots: tuple[str, ...], when_full: Literal["drop", "wait"], clock_s: Callable[[], float] = time.monotonic
    ) -> None:
        self._bus, self._robots, self._clock_s = bus, robots, clock_s
        self._frames = {robot: bus.publisher(replace(topics.FRAME, when_full=when_full), robot=robot) for robot in robots}
        readings = replace(topics.WHEEL_READINGS, when_full=when_full)
        self._readings = {robot: bus.publisher(readings, robot=robot) for robot in robots}
        self._commands = {robot: bus.inbox(topics.WHEEL_COMMAND, robot=robot) for robot in robots}
        self._cameras, self._wheels = bus.presence(topics.CAMERA_READY), bus.presence(topics.WHEELS_READY)
        self._time = bus.publisher(replace(topics.WORLD_TIME, when_full=when_full))
        self._truth = bus.publisher(topics.WORLD_TRUTH)

    @property
    def present(self) -> frozenset[str]:
        """The robots whose camera and wheels both listen."""
        return self._cameras.present & self._wheels.present & frozenset(self._robots)

    def wait_until_ready(self, stopping: Callable[[], bool]) -> None:
        """Return when every robot's camera and wheels listen; who is missing for long is named once."""
        named_s = self._clock_s() + _NAME_MISSING_S
        while (missing := frozenset(self._robots) - self.present) and not stopping():
            if self._clock_s() >= named_s:
                named_s = math.inf
                _log.warning("waiting for the drivers of %s", ", ".join(sorted(missing)))
            self.wait(_TURN_S)

    def take(self) -> list[ArrivedCommand]:
        """Return the commands that have come, robot by robot, each robot's oldest first."""
        commands: list[ArrivedCommand] = []
        for robot, inbox in self._commands.items():
            taken = inbox.take()
            arrived_s = self._clock_s() - inbox.age_s if taken else 0.0
            commands.extend(ArrivedCommand(robot, command, arrived_s) for command in taken)
        return commands

    def wait(self, timeout_s: float) -> None:
        """Sleep until a command may have come, somebody has come or gone, or the time is over."""
        self._bus.wait(timeout_s)

    def send_readings(self, robot: str, until_ns: int, encoders: EncoderRows) -> None:
        """Tell a robot what its encoders have read since the last time."""
        rows = Packed.of(encoders.stamps_ns, "i8"), Packed.of(encoders.angles_rad, "f8")
        self._readings[robot].put(WheelReadings(until_ns=until_ns, stamps_ns=rows[0], angles_rad=rows[1]))

    def send_frame(self, robot: str, stamp_ns: int, picture: Picture) -> None:
        """Hand a robot its picture, as it is."""
        rows, columns, _ = picture.shape
        self._frames[robot].put(Frame(stamp_ns=stamp_ns, encoding="bgr8", shape=(rows, columns), data=picture.tobytes()))

    def send_time(self, moment: Moment, fired: tuple[str, ...]) -> None:
        """Announce that everything of this moment has been handed out, and the truth about it."""
        bodies = tuple(
            BodyTruth(
                robot=placed.body.name,
                arena_from_body=pose_tuple(placed.arena_from_body),
                collisions=moment.collision_counts[placed.body.name],
            )
            for placed in moment.robots
        )
        self._truth.put(WorldTruth(stamp_ns=moment.stamp_ns, bodies=bodies))
        self._time.put(WorldTime(stamp_ns=moment.stamp_ns, robots=fired))
