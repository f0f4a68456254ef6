"""What robots have come up against: one that cannot follow its reference has something before it, though the map may not show it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from mapserver.formation.costmap import CostMap, Disc
from mapserver.formation.task import Moment
from mapserver.formation.trail import Reference
from protocol.geometry import Array, Pose2

BEHIND_M = 0.05  # from its reference: a robot that is driving does not fall back so far ...
STILL_M, STILL_S = 0.01, 1.2  # ... nor stay where it is for so long
THING_RADIUS_M, MARGIN_M = 0.04, 0.02  # of what is taken to stand there, and its distance from the robot that it holds up
KNOWN_M = 0.03  # from what the map shows: then that is what holds the robot up
MET_M = 0.12  # between the bodies of robots that may be in each other's way
LASTS_NS = 30_000_000_000


class _Bump(NamedTuple):
    thing: Disc
    stamp_ns: int


class Bumps:
    """Remembers for a while where robots were held up."""

    def __init__(self, radius_m: float) -> None:
        """All robots are as wide as the widest."""
        self._radius_m = radius_m
        self._still: dict[str, tuple[Pose2, int]] = {}  # where each robot is, and since when
        self._bumps: list[_Bump] = []

    def note(self, moment: Moment, references: Mapping[str, Reference], cost_map: CostMap) -> None:
        """Take in where the robots are, given what they were last told to follow, and the map without bumps."""
        self._bumps = [bump for bump in self._bumps if moment.stamp_ns - bump.stamp_ns <= LASTS_NS]
        self._still = {name: self._since(name, pose, moment.stamp_ns) for name, pose in moment.poses.items()}
        for name, (_, since_ns) in self._still.items():
            if name in references and (moment.stamp_ns - since_ns) * 1e-9 >= STILL_S:
                self._come_up_against(name, references[name].arena_from_body, moment, cost_map)

    def things(self) -> Sequence[Disc]:
        """Return what is taken to stand where robots were held up."""
        return [bump.thing for bump in self._bumps]

    def _since(self, name: str, pose: Pose2, stamp_ns: int) -> tuple[Pose2, int]:
        was = self._still.get(name)
        return was if was is not None and math.dist(was[0][:2], pose[:2]) < STILL_M else (pose, stamp_ns)

    def _come_up_against(self, name: str, reference: Pose2, moment: Moment, cost_map: CostMap) -> None:
        """Note a thing between a robot and its reference, unless the map, or another robot, says what holds it up."""
        place_m = np.array(moment.poses[name][:2])
        way_m = np.array(reference[:2]) - place_m
        behind_m = float(np.hypot(*way_m))
        if behind_m < BEHIND_M:
            return
        centre_m = place_m + way_m / behind_m * (self._radius_m + MARGIN_M + THING_RADIUS_M)
        others = [pose for other, pose in {**moment.poses, **moment.lost}.items() if other != name]
        if not self._is_known(centre_m, others, moment.moving, cost_map):
            self._bumps = [bump for bump in self._bumps if math.dist(bump.thing.centre_m, centre_m) > THING_RADIUS_M]
            self._bumps.append(_Bump(Disc(centre_m, THING_RADIUS_M), moment.stamp_ns))

    def _is_known(self, centre_m: Array, others: Sequence[Pose2], moving: Sequence[Array], cost_map: CostMap) -> bool:
        met_m = self._radius_m + THING_RADIUS_M + MET_M
        is_met = any(math.dist(pose[:2], centre_m) < met_m for pose in others)
        is_passed = any(float(np.hypot(*(footprint_m - centre_m).T).min()) < met_m for footprint_m in moving)
        return is_met or is_passed or float(cost_map.clearance_m(centre_m)) < KNOWN_M
