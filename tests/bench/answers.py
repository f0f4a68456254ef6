"""From setpoints that were broadcast to wheel commands that answer them: when each came, and what can be said of all of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from protocol.inbox import Arrived
from protocol.messages import Setpoints, WheelCommand
from tests.bench.statistics import Times, times

SETTLING_NS = 500_000_000  # setpoints of the last half second may still be on their way when listening ends

Broadcasts = Sequence[Arrived[Setpoints]]
Commands = Mapping[str, Sequence[Arrived[WheelCommand]]]  # by robot


@dataclass(frozen=True)
class Answers:
    """How soon setpoints were answered."""

    delays_ms: tuple[float, ...]  # of every robot's first command for a stamp after the first broadcast of that stamp
    unanswered: int  # setpoints of a robot for a stamp

    @property
    def times(self) -> Times:
        """Return median and 99th percentile of the delays."""
        return times(self.delays_ms)


def answers(broadcasts: Broadcasts, commands: Commands) -> Answers:
    """Return how soon each robot answered each stamp at which it had a setpoint; the last half second only counts where it was answered."""
    said_s: dict[tuple[str, int], float] = {}
    for setpoints, arrived_s, _ in broadcasts:
        for setpoint in setpoints.robots:
            said_s.setdefault((setpoint.robot, setpoints.stamp_ns), arrived_s)
    done_s: dict[tuple[str, int], float] = {}
    for robot, given in commands.items():
        for command, arrived_s, _ in given:
            done_s.setdefault((robot, command.answers_ns), arrived_s)
    last_ns = max((stamp_ns for _, stamp_ns in said_s), default=0)
    # Two sessions of one process may hear an answer just before what it answers.
    delays_ms = tuple(1e3 * max(0.0, done_s[key] - said_s[key]) for key in said_s if key in done_s)
    unanswered = sum(key not in done_s and key[1] <= last_ns - SETTLING_NS for key in said_s)
    return Answers(delays_ms, unanswered)
