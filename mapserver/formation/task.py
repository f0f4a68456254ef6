"""What the swarm is asked to do, and what is known at the moment it has to do the next bit of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from mapserver.formation.floor import Bounds, Floor
from mapserver.formation.shapes import Shape
from protocol.geometry import Array, Pose2


@dataclass(frozen=True)
class Task:
    """A formation and where it is to go; `explores`: to all of the floor and home again, whatever the goals."""

    shape: Shape
    leader: str  # who leads while it is there
    goals: tuple[tuple[float, float], ...] = ()  # [m; arena], one after the other
    explores: bool = False
    cruise_m_s: float = 0.15
    max_speed_m_s: float = 0.22
    bounds: Bounds | None = None  # nobody drives beyond


class Moment(NamedTuple):
    """All that the formation is told at one stamp."""

    stamp_ns: int
    poses: Mapping[str, Pose2]  # arena_from_body of the robots that are there
    lost: Mapping[str, Pose2]  # where those stand that are not, as far as anybody knows
    floor: Floor
    moving: Sequence[Array] = ()  # footprints of moving objects, (n, 2) [m; arena] each
    stopped: str = ""  # why the swarm is held; empty: it is not
