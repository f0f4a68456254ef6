"""What a running robot has learned of its rig by now, and where it went meanwhile; and the rig of one that is pushed by hand."""

from __future__ import annotations

import math
import time
from collections.abc import Callable

from deploy.calibration.rig import Watched
from protocol.bus import Bus
from protocol.errors import LinkError
from protocol.messages import AgentStatus
from protocol.topics import AGENT_REPORT, LOCAL_MAP

ANSWER_TIMEOUT_S, TURN_S = 2.0, 1.0
FIGURE = (
    "Push the robot slowly, by hand: a metre straight ahead, once round on the spot to the left, once round to the right, and back.",
    "Nothing here turns its wheels. Press Ctrl-C to give up.",
)


class LiveRobot:
    """One robot whose agent runs; `look` takes what has come of it."""

    def __init__(self, bus: Bus, robot: str) -> None:
        """Begin to listen; raises LinkError where the robot's agent does not answer, before anybody moves it for nothing."""
        self._bus, self._robot = bus, robot
        self._maps = bus.inbox(LOCAL_MAP, robot=robot)
        self._first: tuple[float, float] | None = None  # its first place [m; odom]
        self.pictures = 0  # that it could use
        self.way_m = 0.0  # from its first place to where it is
        self.farthest_m = 0.0
        self.status()

    def look(self) -> None:
        """Take note of where the robot has been since."""
        for local_map in self._maps.take():
            if local_map.picture == "used":
                place = local_map.odom_from_body[:2]
                self._first = self._first or place
                self.pictures += 1
                self.way_m = math.dist(self._first, place)
                self.farthest_m = max(self.farthest_m, self.way_m)

    def status(self) -> AgentStatus:
        """Return what the agent says of itself; raises LinkError where it does not answer."""
        answers = self._bus.ask(AGENT_REPORT, ANSWER_TIMEOUT_S, robot=self._robot)
        if not answers:
            raise LinkError(f"{self._robot}: its agent does not answer; start it, and the map server, first")
        return answers[0]

    def watched(self, reached_m: float) -> Watched:
        """Return what the agent has learned, the robot having gone so far; raises LinkError where it has learned nothing."""
        status = self.status()
        if not status.rig or not self.pictures:
            raise LinkError(f"{self._robot}: its agent tells nothing of its rig ({status.state}): it needs pictures, and the method `full`")
        return Watched(status.rig, self.pictures, reached_m)


def watch_pushed(bus: Bus, robot: str, seconds_s: float, progress: Callable[[float], None]) -> Watched:
    """Return what a running robot has learned of its rig after so many seconds; `progress` is told the seconds that have passed.

    Raises LinkError where its agent does not answer.
    """
    pushed = LiveRobot(bus, robot)
    start_s = time.monotonic()
    while (passed_s := time.monotonic() - start_s) < seconds_s:
        bus.wait(min(TURN_S, seconds_s - passed_s))
        pushed.look()
        progress(time.monotonic() - start_s)
    return pushed.watched(pushed.farthest_m)
