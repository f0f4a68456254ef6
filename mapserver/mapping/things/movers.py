"""What moves on the floor and is no robot: nothing for the map, but something to keep away from."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import shapely

from mapserver.mapping.bodies import Body
from protocol.geometry import Array, Pose2
from protocol.messages import LocalMap, Region

MEMORY_NS = 1_000_000_000
LEAST_LOOKS = 3  # within the memory: one wrong look stops nobody
LEAST_WAY_M = 0.08  # from the first of these looks to the last
NEAR_PART_M = 0.35  # of an outline: what lies further behind its nearest point is smear


class _Look(NamedTuple):
    stamp_ns: int
    who: tuple[str, int]  # robot and its label
    footprint_m: Array  # (n, 2) [arena]


class MoverWatch:
    """Holds the last looks at moving things; `observe` local maps, then read where they are."""

    def __init__(self) -> None:
        """Start with nothing seen."""
        self._looks: list[_Look] = []

    def observe(self, local_map: LocalMap, arena_from_body: Pose2, bodies: Sequence[Body]) -> None:
        """Take what one robot saw moving from `arena_from_body`, the other robots standing at `bodies`."""
        self._looks = [look for look in self._looks if local_map.stamp_ns - look.stamp_ns <= MEMORY_NS]
        for region in local_map.regions:
            if region.motion == "moving":
                footprint_m = _near_part(region, arena_from_body)
                if not any(_is_robot(footprint_m, body) for body in bodies):
                    self._looks.append(_Look(local_map.stamp_ns, (local_map.robot, region.label), footprint_m))

    def footprints(self, stamp_ns: int) -> list[Array]:
        """Return the last footprint, (n, 2) [m; arena], of everything that was seen to move often enough lately."""
        by_who: defaultdict[tuple[str, int], list[Array]] = defaultdict(list)
        for look in self._looks:
            if 0 <= stamp_ns - look.stamp_ns <= MEMORY_NS:
                by_who[look.who].append(look.footprint_m)
        return [looks[-1] for looks in by_who.values() if len(looks) >= LEAST_LOOKS and _has_moved(looks[0], looks[-1])]


def _near_part(region: Region, arena_from_body: Pose2) -> Array:
    outline_m = region.outline.metres()
    distances_m = np.hypot(*outline_m.T)
    return arena_from_body.apply(outline_m[distances_m <= distances_m.min() + NEAR_PART_M])


def _has_moved(first_m: Array, last_m: Array) -> bool:
    """Tell whether something is elsewhere than it was: what only looks as if it moved, a wrong parallax, stays where it is."""
    return math.dist(first_m.mean(axis=0), last_m.mean(axis=0)) > LEAST_WAY_M


def _is_robot(footprint_m: Array, body: Body) -> bool:
    """Tell whether the nearest part of an outline is, or touches, a robot that is known."""
    return bool(
        shapely.dwithin(shapely.convex_hull(shapely.multipoints(footprint_m)), shapely.Point(body.position_m), body.shadow_radius_m())
    )
