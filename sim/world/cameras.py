"""What the robots' cameras show at one moment, and what goes wrong with them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from protocol.geometry import Pose2
from sim.world.scene import Placed, Thing
from sim.world.world import Moment

Picture = NDArray[np.uint8]  # (rows, columns, 3), BGR

DARK_LEVELS = 4  # what a covered sensor still shows is noise below this value


class Eye(Protocol):
    """One robot's camera in a scene that does not move."""

    def render(self, arena_from_body: Pose2, others: Sequence[Placed], people: Sequence[Thing], height_m: float = 0.0) -> Picture:
        """Return the picture from a robot at its place, so high above the floor, among other robots and people."""
        ...


class CameraFault(NamedTuple):
    """A while in which a robot's camera shows its last picture again, darkness, or nothing."""

    robot: str
    kind: Literal["camera_freezes", "camera_dark", "camera_silent"]
    from_ns: int
    until_ns: int


class Cameras:
    """All robots' cameras."""

    def __init__(self, eyes: Mapping[str, Eye], seed: int, faults: Sequence[CameraFault] = ()) -> None:
        self._eyes, self._faults = dict(eyes), tuple(faults)
        self._last: dict[str, Picture] = {}
        self._rng = np.random.default_rng([seed, len(self._eyes)])

    def fired(self, stamp_ns: int) -> tuple[str, ...]:
        """Return the robots whose cameras give a picture at a stamp."""
        return tuple(name for name in self._eyes if self._fault(name, stamp_ns) != "camera_silent")

    def picture(self, robot: str, moment: Moment) -> Picture:
        """Return what a robot's camera shows."""
        fault = self._fault(robot, moment.stamp_ns)
        if fault == "camera_freezes" and robot in self._last:
            return self._last[robot]
        seen = self._seen(robot, moment)
        if fault == "camera_dark":
            return self._rng.integers(0, DARK_LEVELS, seen.shape, dtype=np.uint8)
        self._last[robot] = seen
        return seen

    def _seen(self, robot: str, moment: Moment) -> Picture:
        [own] = [placed for placed in moment.robots if placed.body.name == robot]
        others = [placed for placed in moment.robots if placed is not own and placed.height_m == 0.0]
        return self._eyes[robot].render(own.arena_from_body, others, moment.people, own.height_m)

    def _fault(self, robot: str, stamp_ns: int) -> str | None:
        return next((fault.kind for fault in self._faults if fault.robot == robot and fault.from_ns <= stamp_ns < fault.until_ns), None)
