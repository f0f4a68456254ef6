"""A robot's body in motion: commands that take effect after a delay, wheels that turn and slip, encoders that are read."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from protocol.geometry import Pose2
from sim.world.collisions import Contacts
from sim.world.drive import FULL_GRIP, STILL, Drive, Turning, Wheels, encoder_angles_rad, moved, rolled_m, turned
from sim.world.scene import Placed, RobotBody

CARRIED_M = 0.25  # above the floor


class Slip(NamedTuple):
    """A while in which wheels turn more than they move the robot."""

    from_ns: int
    until_ns: int
    grip: Wheels  # 1: as on dry floor; 0: the wheel spins on the spot


class Lift(NamedTuple):
    """A while in which somebody carries the robot elsewhere; in the end it stands there."""

    from_ns: int
    until_ns: int
    to: Pose2  # arena_from_body


class Body:
    """One robot's body; what it is told takes effect later, and stays in effect until it is told something else."""

    def __init__(
        self,
        body: RobotBody,
        start: Pose2,
        drive: Drive,
        command_delay_ns: int,
        rng: np.random.Generator,
        slips: Sequence[Slip] = (),
        lifts: Sequence[Lift] = (),
    ) -> None:
        """Put the body down at its true start, arena_from_body."""
        self.body, self.arena_from_body, self.contacts = body, start, Contacts()
        self._lifts, self._lifted_from = tuple(lifts), start
        self.is_carried = False
        self._drive, self._delay_ns, self._rng, self._slips = drive, command_delay_ns, rng, tuple(slips)
        self._turning = Turning(STILL, STILL)
        self._command = STILL
        self._coming: deque[tuple[int, Wheels]] = deque()  # when it takes effect, and the command

    @property
    def name(self) -> str:
        """The robot's name."""
        return self.body.name

    def command(self, speeds_rad_s: Wheels, at_ns: int) -> None:
        """Take a command that arrives at a stamp."""
        self._coming.append((at_ns + self._delay_ns, speeds_rad_s))

    def turn_wheels(self, from_ns: int, until_ns: int) -> Pose2:
        """Let the wheels turn for a while, and return where they would move the body if nothing is in its way."""
        while self._coming and self._coming[0][0] <= from_ns:
            self._command = self._coming.popleft()[1]
        before = self._turning
        self._turning = turned(self._drive, before, self._command, (until_ns - from_ns) / 1e9)
        angles_rad = Wheels(*(after - angle for angle, after in zip(before.angles_rad, self._turning.angles_rad, strict=True)))
        noise = Wheels(*self._rng.standard_normal(2).tolist())
        return moved(self._drive, self.arena_from_body, rolled_m(self._drive, angles_rad, self._grip(from_ns), noise))

    def carry(self, until_ns: int) -> bool:
        """Let hands, if any, carry the body on until a stamp, straight to where they put it down; tell whether they hold it then."""
        lift = next((lift for lift in self._lifts if lift.from_ns < until_ns <= lift.until_ns), None)
        if lift is not None:
            self._lifted_from = self._lifted_from if self.is_carried else self.arena_from_body
            way = self._lifted_from.between(lift.to).log() * ((until_ns - lift.from_ns) / (lift.until_ns - lift.from_ns))
            self.arena_from_body = self._lifted_from @ Pose2.exp(way)
        self.is_carried = lift is not None
        return self.is_carried

    def placed(self) -> Placed:
        """Return the body at its place."""
        return Placed(self.body, self.arena_from_body, CARRIED_M if self.is_carried else 0.0)

    def encoders_rad(self) -> Wheels:
        """Return the cumulative angles that the encoders tell."""
        return encoder_angles_rad(self._drive, self._turning.angles_rad)

    def _grip(self, at_ns: int) -> Wheels:
        return next((slip.grip for slip in self._slips if slip.from_ns <= at_ns < slip.until_ns), FULL_GRIP)
