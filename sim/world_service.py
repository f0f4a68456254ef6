"""The simulated world's loop: receive commands, step, publish, keep pace. It owns all input and output; the world below it has none."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Protocol

from sim.real_time import Pace
from sim.robot_links import RobotLinks
from sim.stepping import Stepping
from sim.world.cameras import Cameras, Picture
from sim.world.drive import Wheels
from sim.world.world import EncoderRows, Moment, World

TURN_S = 0.2  # the longest sleep in one turn of a waiting loop


class Witness(Protocol):
    """Keeps what the robots are shown."""

    def add_wheels(self, robot: str, encoders: EncoderRows) -> None:
        """Keep encoder readings."""
        ...

    def add_picture(self, robot: str, stamp_ns: int, picture: Picture) -> None:
        """Keep a frame."""
        ...


class Blind:
    """The witness that keeps nothing."""

    def add_wheels(self, robot: str, encoders: EncoderRows) -> None:
        """Let it pass."""

    def add_picture(self, robot: str, stamp_ns: int, picture: Picture) -> None:
        """Let it pass."""


class WorldService:
    """Turns a world, shows it to the robots' drivers and lets these drive its bodies."""

    def __init__(
        self,
        world: World,
        cameras: Cameras,
        links: RobotLinks,
        stepping: Stepping,
        pace: Pace,
        *,
        tell: Callable[[Moment], None],
        witness: Witness | None = None,
        clock_s: Callable[[], float] = time.monotonic,
    ) -> None:
        """Tell the truth of every moment by `tell`, before the robots hear that the moment is there."""
        self._world, self._cameras, self._links = world, cameras, links
        self._stepping, self._pace, self._clock_s = stepping, pace, clock_s
        self._tell, self._witness = tell, witness or Blind()

    def run(self, until_ns: int, stopping: Callable[[], bool]) -> None:
        """Turn until a stamp, or until asked to stop."""
        while self._world.next_ns <= until_ns:
            self._receive(stopping)
            if stopping():
                return
            self._pace.began(self._world.next_ns)
            moment = self._world.step()
            self._tell(moment)
            self._publish(moment)

    def _receive(self, stopping: Callable[[], bool]) -> None:
        """Take commands until the next step may begin and is due."""
        self._take_commands()
        while not stopping() and (left_s := self._left_s()) > 0.0:
            self._links.wait(min(left_s, TURN_S))
            self._take_commands()

    def _left_s(self) -> float:
        """Return how long the next step has to wait at least."""
        now_s = self._clock_s()
        if not self._stepping.may_go_on(self._links.present, now_s):
            return TURN_S
        return self._pace.due_s(self._world.next_ns) - now_s

    def _take_commands(self) -> None:
        for robot, command, arrived_s in self._links.take():
            at_ns = self._stepping.arrived(robot, command, arrived_s)
            self._world.command(robot, Wheels(command.left_rad_s, command.right_rad_s), at_ns)

    def _publish(self, moment: Moment) -> None:
        """Hand out a moment: all readings, each frame as soon as it is rendered, and last that all of it is there."""
        listeners = self._links.present  # before they can answer
        for robot, encoders in moment.encoders.items():
            self._witness.add_wheels(robot, encoders)
            self._links.send_readings(robot, moment.stamp_ns, encoders)
        fired: list[str] = []
        for robot in self._cameras.fired(moment.stamp_ns):
            if not self._pace.may_show(self._world.next_ns):
                continue
            fired.append(robot)
            picture = self._cameras.picture(robot, moment)
            self._links.send_frame(robot, moment.stamp_ns, picture)
            self._witness.add_picture(robot, moment.stamp_ns, picture)
        self._stepping.shown(moment.stamp_ns, listeners, self._clock_s())
        self._links.send_time(moment, tuple(fired))
