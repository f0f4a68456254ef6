"""The world that moves: bodies driven by their wheels among things and people, from one camera frame to the next."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from protocol.geometry import Array, Pose2
from sim.world.bodies import Body
from sim.world.collisions import Near, Obstacles, body_clearance_m, is_blocked
from sim.world.drive import Wheels
from sim.world.people import Walker
from sim.world.scene import Placed, Thing

SUBSTEP_NS = 5_000_000
ENCODER_PERIOD_NS = 20_000_000  # 50 Hz

_REACH_M = 0.02  # beyond a body's radius: farther things cannot be touched within a substep


class Collision(NamedTuple):
    """The moment in which a robot ran into something."""

    stamp_ns: int
    robot: str
    other: str  # the thing, wall, leg or robot


@dataclass(frozen=True, eq=False)
class EncoderRows:
    """What one robot's encoders told, oldest first."""

    stamps_ns: NDArray[np.int64]  # (n,)
    angles_rad: Array  # (n, 2) left, right; cumulative


@dataclass(frozen=True)
class Moment:
    """The world at one stamp, and what has happened since the last one."""

    stamp_ns: int
    robots: tuple[Placed, ...]
    people: tuple[Thing, ...]
    encoders: Mapping[str, EncoderRows]  # by robot
    collisions: tuple[Collision, ...]
    collision_counts: Mapping[str, int]  # by robot, since the world's start


@dataclass
class _Happenings:
    """What is gathered between two moments."""

    stamps_ns: list[int] = field(default_factory=list)
    angles_rad: dict[str, list[Wheels]] = field(default_factory=dict)
    collisions: list[Collision] = field(default_factory=list)


class World:
    """Bodies, things and people. The first step shows the start, every further one the world a period later."""

    def __init__(
        self, start_ns: int, period_ns: int, things: Sequence[Thing], bodies: Sequence[Body], walkers: Sequence[Walker] = ()
    ) -> None:
        self._start_ns, self._period_ns = start_ns, period_ns
        self._things = Obstacles(things)
        self._bodies = tuple(bodies)
        self._by_name = {body.name: body for body in bodies}
        self._walkers = tuple(walkers)
        self._now_ns = start_ns
        self._steps = 0

    @property
    def names(self) -> tuple[str, ...]:
        """The robots, in the scenario's order."""
        return tuple(self._by_name)

    @property
    def now_ns(self) -> int:
        """The stamp of the last moment."""
        return self._now_ns

    @property
    def next_ns(self) -> int:
        """The stamp of the next moment."""
        return self._start_ns + self._steps * self._period_ns

    @property
    def collision_counts(self) -> dict[str, int]:
        """How often each robot has run into something."""
        return {body.name: body.contacts.count for body in self._bodies}

    def command(self, robot: str, speeds_rad_s: Wheels, at_ns: int) -> None:
        """Let a wheel command arrive at a stamp, which is not before the last moment; it holds until the next one takes effect."""
        self._by_name[robot].command(speeds_rad_s, at_ns)

    def step(self) -> Moment:
        """Go on to the next moment, and show it."""
        seen = _Happenings(angles_rad={name: [] for name in self.names})
        if self._steps == 0:
            self._read_encoders(seen)
        for until_ns in _substeps(self._now_ns - self._start_ns, self.next_ns - self._start_ns):
            self._advance(self._start_ns + until_ns, seen)
        self._steps += 1
        return self._moment(seen)

    def _advance(self, until_ns: int, seen: _Happenings) -> None:
        legs = self._legs(until_ns)
        people = Obstacles(legs)
        for body in self._bodies:
            target = body.turn_wheels(self._now_ns, until_ns)
            if not body.carry(until_ns):
                self._move(body, target, people, until_ns, seen)
        self._now_ns = until_ns
        if (until_ns - self._start_ns) % ENCODER_PERIOD_NS == 0:
            self._read_encoders(seen)

    def _move(self, body: Body, target: Pose2, people: Obstacles, until_ns: int, seen: _Happenings) -> None:
        """Move a body, unless something is in its way: then it only turns on the spot, and its wheels slip."""
        radius_m = body.body.body_radius_m
        near = self._near(body, target, people)
        seen.collisions.extend(Collision(until_ns, body.name, other) for other in body.contacts.meet(near, radius_m))
        if any(is_blocked(other, radius_m) for other in near):
            target = Pose2(body.arena_from_body.x_m, body.arena_from_body.y_m, target.theta_rad)
        body.arena_from_body = target

    def _near(self, body: Body, target: Pose2, people: Obstacles) -> list[Near]:
        """Return all that a body could touch on its way to `target`."""
        before, after = _point(body.arena_from_body), _point(target)
        reach_m = body.body.body_radius_m + _REACH_M
        robots = [
            Near(
                other.name, *(body_clearance_m(point, _point(other.arena_from_body), other.body.body_radius_m) for point in (before, after))
            )
            for other in self._bodies
            if other is not body and not other.is_carried
        ]
        return [*self._things.near(before, after, reach_m), *people.near(before, after, reach_m), *robots]

    def _read_encoders(self, seen: _Happenings) -> None:
        seen.stamps_ns.append(self._now_ns)
        for body in self._bodies:
            seen.angles_rad[body.name].append(body.encoders_rad())

    def _legs(self, stamp_ns: int) -> tuple[Thing, ...]:
        time_s = (stamp_ns - self._start_ns) / 1e9
        return tuple(leg for walker in self._walkers for leg in walker.legs(time_s))

    def _moment(self, seen: _Happenings) -> Moment:
        stamps_ns = np.array(seen.stamps_ns, dtype=np.int64)
        return Moment(
            stamp_ns=self._now_ns,
            robots=tuple(body.placed() for body in self._bodies),
            people=self._legs(self._now_ns),
            encoders={name: EncoderRows(stamps_ns, np.reshape(np.array(rows), (-1, 2))) for name, rows in seen.angles_rad.items()},
            collisions=tuple(seen.collisions),
            collision_counts=self.collision_counts,
        )


def _substeps(from_ns: int, until_ns: int) -> Iterator[int]:
    """Yield the ends of the substeps between two times since the start: whole multiples of `SUBSTEP_NS`, and `until_ns`."""
    first_ns = (from_ns // SUBSTEP_NS + 1) * SUBSTEP_NS
    yield from range(first_ns, until_ns, SUBSTEP_NS)
    if until_ns > from_ns:
        yield until_ns


def _point(pose: Pose2) -> tuple[float, float]:
    return (pose.x_m, pose.y_m)
