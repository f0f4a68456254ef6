"""The rig from a robot that runs: its agent learns while the robot is pushed by hand, and is asked what it knows by now."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

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


def watch_robot(bus: Bus, robot: str, seconds_s: float, progress: Callable[[float], None]) -> Watched:
    """Return what a running robot has learned of its rig after so many seconds; `progress` is told the seconds that have passed.

    Raises LinkError where its agent does not answer.
    """
    maps = bus.inbox(LOCAL_MAP, robot=robot)
    _ask(bus, robot)  # before anybody pushes for nothing
    places: list[tuple[float, float]] = []
    start_s = time.monotonic()
    while (passed_s := time.monotonic() - start_s) < seconds_s:
        bus.wait(min(TURN_S, seconds_s - passed_s))
        places += [local_map.odom_from_body[:2] for local_map in maps.take() if local_map.picture == "used"]
        progress(time.monotonic() - start_s)
    status = _ask(bus, robot)
    if not status.rig or not places:
        raise LinkError(f"{robot}: its agent tells nothing of its rig ({status.state}): it needs pictures, and the method `full`")
    offset = np.array(places) - places[0]
    return Watched(status.rig, len(places), float(np.hypot(offset[:, 0], offset[:, 1]).max()))


def _ask(bus: Bus, robot: str) -> AgentStatus:
    answers = bus.ask(AGENT_REPORT, ANSWER_TIMEOUT_S, robot=robot)
    if not answers:
        raise LinkError(f"{robot}: its agent does not answer; start it, and the map server, first")
    return answers[0]
