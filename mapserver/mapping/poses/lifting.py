"""Robots that were lifted and put down elsewhere: they are seen, and see others, but not where they are believed to be.

A robot stands accused while no sighting ties it to another as believed, and one that is tied so itself sees a stranger exactly as far away
as the robot does: these two see each other. Who is accused for a while without a break has lost its place.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import NamedTuple

from mapserver.mapping.poses.association import Match
from protocol.messages import LocalMap, Sighting

SAME_RANGE_M = 0.03  # two robots that see each other tell the same range, but for both their errors
LIFTED_NS = 1_000_000_000  # of being accused: by then it is no passing error, nor a thing once taken for a robot
LEAST_LOOKS = 5  # in that time


class Look(NamedTuple):
    """What one robot saw, and which of it shows other robots where they are believed to be."""

    local_map: LocalMap
    matches: Sequence[Match]

    def strangers(self) -> list[Sighting]:
        """Return the sightings that nobody named, and that show no robot where one is believed to be."""
        explained = [match.sighting for match in self.matches]
        return [each for each in self.local_map.sightings if each.identity.kind == "none" and each not in explained]


class _Doubt(NamedTuple):
    """Since when a robot is accused, when it was so last, and in how many looks."""

    since_ns: int
    last_ns: int
    looks: int


class LiftWatch:
    """Remembers who is accused; `note` the looks of each step, then ask whom to believe."""

    def __init__(self) -> None:
        """Start with nobody accused."""
        self._doubts: dict[str, _Doubt] = {}
        self._lifted: set[str] = set()

    def note(self, stamp_ns: int, looks: Sequence[Look]) -> None:
        """Take the looks of one step, of robots that have a place; who is not accused again for a while is so no more."""
        self._doubts = {robot: doubt for robot, doubt in self._doubts.items() if stamp_ns - doubt.last_ns < LIFTED_NS}
        tied = {robot for look in looks for match in look.matches for robot in (look.local_map.robot, match.robot)}
        for robot in tied:
            self._doubts.pop(robot, None)
        for robot in accused(looks, tied):
            since_ns, _, looked = self._doubts.get(robot, _Doubt(stamp_ns, stamp_ns, 0))
            self._doubts[robot] = _Doubt(since_ns, stamp_ns, looked + 1)
            if stamp_ns - since_ns >= LIFTED_NS and looked + 1 >= LEAST_LOOKS:
                self._lifted.add(robot)

    def is_doubted(self, robot: str) -> bool:
        """Tell whether a robot is accused: until that is settled nothing that it sees belongs in the map."""
        return robot in self._doubts

    def take_lifted(self, robot: str) -> bool:
        """Tell, once, whether a robot has lost its place; it may find one anew, without a doubt."""
        if robot not in self._lifted:
            return False
        self._lifted.remove(robot)
        self._doubts.pop(robot, None)
        return True


def accused(looks: Sequence[Look], tied: Collection[str]) -> list[str]:
    """Return the robots that are not tied, and of which one that is sees a stranger as far away as they see one."""
    ranges_m = [stranger.range_m for look in looks if look.local_map.robot in tied for stranger in look.strangers()]
    return [look.local_map.robot for look in looks if look.local_map.robot not in tied and _sees_back(look, ranges_m)]


def _sees_back(look: Look, ranges_m: Sequence[float]) -> bool:
    return any(abs(stranger.range_m - range_m) < SAME_RANGE_M for stranger in look.strangers() for range_m in ranges_m)
