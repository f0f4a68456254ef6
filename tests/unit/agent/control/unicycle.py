"""A robot on a plane whose motors follow their commands with a lag, for the tests of the controller."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from agent.control.limits import DriveLimits, applied
from agent.control.tracking import Reference, track
from agent.control.twist import STANDING, Twist
from protocol.geometry import Pose2

PERIOD_S = 0.1  # between two commands
STEPS = 10  # of the motion in between
LIMITS = DriveLimits()


@dataclass
class Unicycle:
    """Speed and turn rate come up to the command with a time constant."""

    pose: Pose2
    lag_s: float = 0.12
    twist: Twist = STANDING

    def drive(self, command: Twist) -> None:
        """Go on for one period."""
        step_s = PERIOD_S / STEPS
        share = 1.0 - np.exp(-step_s / self.lag_s)
        for _ in range(STEPS):
            speed, turn = (now + share * (then - now) for now, then in zip(self.twist, command, strict=True))
            self.twist = Twist(speed, turn)
            self.pose = self.pose @ self.twist.motion(step_s)


def errors_while_following(robot: Unicycle, reference: Reference, duration_s: float, noise: np.random.Generator) -> Iterator[Pose2]:
    """Follow a reference that goes on as it is, with a pose that is known to 2 mm and 0.2 degrees; yield the true errors."""
    command = STANDING
    for step in range(round(duration_s / PERIOD_S)):
        target = reference.later(step * PERIOD_S)
        blur = noise.normal(0.0, (0.002, 0.002, 0.0035))
        seen = (robot.pose @ Pose2(*blur)).between(target.arena_from_body)
        command = applied(track(seen, target.twist), command, PERIOD_S, LIMITS)
        yield robot.pose.between(target.arena_from_body)
        robot.drive(command)
