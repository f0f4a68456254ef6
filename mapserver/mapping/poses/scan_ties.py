"""What stands in the arena ties the robots' paths: scans that are kept as references, and who sees the same base lines later.

A reference is a variable of the pose graph that stays: so the oldest poses may leave, and paths still hang on what stands. As in keyframe
SLAM with scans (Lu, Milios, "Globally consistent range scan alignment for environment mapping", Autonomous Robots 1997), but bounded.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from mapserver.mapping.belief import Belief
from mapserver.mapping.bodies import Body
from mapserver.mapping.poses.pose_graph import PoseGraph
from mapserver.mapping.poses.scan import Scan, Standing, scan_of
from mapserver.mapping.poses.scan_match import LEAST_THINGS, certain_match, own_covariance
from protocol.geometry import Pose2
from protocol.messages import LocalMap

AGAIN_M, AGAIN_RAD = 0.10, 0.3  # who has moved less sees the same with the same errors
MOST_SIGMA_M = 0.10  # who knows its place less well cannot tell which things it sees
SPACING_M = 0.3  # between references
NEAR_M = 0.6  # a reference from farther away shows other sides of things
MOST_TRIED = 2  # of the nearest references
MOST_REFERENCES = 100


class _Reference(NamedTuple):
    """A scan that is kept, and its number in the graph."""

    number: int
    scan: Scan


class ScanTies:
    """Ties local maps that the graph has taken by what the map knows to stand, in the order in which they came."""

    def __init__(self, graph: PoseGraph) -> None:
        """Begin with no references."""
        self._graph = graph
        self._references: list[_Reference] = []
        self._last: dict[str, Pose2] = {}  # where each robot's scan was taken last

    @property
    def references(self) -> int:
        """How many references there are."""
        return len(self._references)

    def tie(self, local_map: LocalMap, standing: Standing, bodies: Sequence[Body]) -> None:
        """Tie the newest pose of a robot that knows its place to the references around, and make it one where there is none near.

        `bodies` are those of the other robots [arena].
        """
        belief = self._graph.belief(local_map.robot, local_map.stamp_ns)
        sigma_m = _sigma_m(belief)
        if sigma_m > MOST_SIGMA_M or not self._has_moved(local_map.robot, belief.arena_from_body):
            return
        scan = scan_of(local_map, belief.arena_from_body, sigma_m, standing, bodies)
        if scan.count_things() < LEAST_THINGS:
            return
        self._last[local_map.robot] = belief.arena_from_body
        near = self._near(belief.arena_from_body)
        for _, reference in near[:MOST_TRIED]:
            arena_from_reference = self._graph.reference(reference.number)
            shown = reference.scan.still_standing(arena_from_reference, sigma_m, standing)
            match = certain_match(scan, shown, arena_from_reference.between(belief.arena_from_body), sigma_m)
            if match is not None:
                self._graph.tie_to_reference(local_map, reference.number, match.reference_from_body, match.covariance)
        if len(self._references) < MOST_REFERENCES and (not near or near[0][0] > SPACING_M):
            self._references.append(_Reference(self._graph.add_reference(local_map, own_covariance(scan)), scan))

    def _has_moved(self, robot: str, arena_from_body: Pose2) -> bool:
        last = self._last.get(robot)
        if last is None:
            return True
        moved = last.between(arena_from_body)
        return math.hypot(moved.x_m, moved.y_m) > AGAIN_M or abs(moved.theta_rad) > AGAIN_RAD

    def _near(self, arena_from_body: Pose2) -> list[tuple[float, _Reference]]:
        """Return the references around a pose with their distance [m], the nearest first."""
        away = [(math.dist(self._graph.reference(each.number)[:2], arena_from_body[:2]), each) for each in self._references]
        return sorted((each for each in away if each[0] < NEAR_M), key=lambda each: each[0])


def _sigma_m(belief: Belief) -> float:
    """Return the standard deviation of a position, in its worst direction."""
    return math.sqrt(float(max(belief.position_covariance().diagonal())))
