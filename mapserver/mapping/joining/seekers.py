"""Robots that nobody knows the place of find it by seeing robots that have one, and being seen; who is not certain goes on looking.

A robot joins when the evidence for one pose is so great that chance does not explain it, nor any other pose (certainty.py).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from mapserver.mapping.belief import Belief
from mapserver.mapping.floor.grid import Cells
from mapserver.mapping.joining.certainty import Claim, certain
from mapserver.mapping.joining.hypotheses import hypotheses_of
from mapserver.mapping.joining.map_match import MapField, base_lines, match_nats
from mapserver.mapping.joining.moments import LATEST_NS, WELL_KNOWN, Glance, Moment, moment_of, remembered
from mapserver.mapping.joining.pairings import pairings_of
from mapserver.mapping.poses.association import associate
from mapserver.mapping.poses.pose_graph import PoseGraph
from protocol.geometry import Array, Pose2
from protocol.messages import LocalMap, Sighting

AGAIN_NS = 1_000_000_000  # after so long all is weighed again, though nothing new was seen: the map may know more
LOOSE = np.diag([0.01, 0.01, 0.01])  # 0.1 m and 0.1 rad: where a robot is entered, for its sightings to draw it in


class Tie(NamedTuple):
    """A sighting of one local map, and whom it shows."""

    local_map: LocalMap
    target: str
    sighting: Sighting


class Join(NamedTuple):
    """Who was found where, and the sightings that tie it to the others."""

    robot: str
    stamp_ns: int
    found: Belief
    ties: list[Tie]


class Seekers:
    """Remembers what robots without a place, and others, saw; `note` local maps, then ask who joins."""

    def __init__(self) -> None:
        """Start with nothing seen."""
        self._latest: dict[str, LocalMap] = {}
        self._glances: dict[str, tuple[Glance, ...]] = {}
        self._changed = False
        self._weighed_ns = 0

    def note(self, local_maps: Sequence[LocalMap], graph: PoseGraph) -> None:
        """Take the local maps of one step, which are in the graph already."""
        self._latest |= {each.robot: each for each in local_maps}
        for each in local_maps:
            if not graph.has_place(each.robot):
                self._look(each, graph.chain(each.robot).stamps_ns[0])

    def joins(self, stamp_ns: int, graph: PoseGraph, known: Callable[[], tuple[Cells, Array]]) -> Join | None:
        """Return a robot that is certain of its place by now, if there is a new one.

        `known` returns the map's cells, (rows, columns), and its lowest corner, (2,) [m; arena].
        """
        if not self._changed and stamp_ns - self._weighed_ns < AGAIN_NS:
            return None
        self._weighed_ns = stamp_ns
        seekers = [robot for robot in self._glances if not graph.has_place(robot)]
        moments = {robot: self._moments(robot, graph) for robot in seekers}
        taken = [pose for robot in self._latest if (pose := graph.pose(robot, stamp_ns)) is not None]
        claims = {robot: _claim(robot, moments[robot], graph.chain(robot).pose(stamp_ns)) for robot in seekers if moments[robot]}
        if any(claim.hypotheses for claim in claims.values()):
            field = MapField(*known())
            claims = {robot: _weighed(claim.without(taken), moments[robot], field) for robot, claim in claims.items()}
        found = certain(claims)
        self._changed = found is not None
        return None if found is None else _join(found, claims[found].hypotheses[0].arena_from_start, moments[found])

    def _look(self, local_map: LocalMap, since_ns: int) -> None:
        """Take a seeker's local map; what was seen before its chain of motion begins is forgotten."""
        known = self._glances.get(local_map.robot, ())
        glances = tuple(each for each in known if each.local_map.stamp_ns >= since_ns)
        others = tuple(
            each
            for robot, each in sorted(self._latest.items())
            if robot != local_map.robot and abs(local_map.stamp_ns - each.stamp_ns) <= LATEST_NS
        )
        after = remembered(glances, Glance(local_map, others))
        self._changed |= after != glances
        self._glances[local_map.robot] = after

    def _moments(self, robot: str, graph: PoseGraph) -> list[Moment]:
        return [moment_of(glance, graph.pose, graph.chain(robot).pose) for glance in self._glances[robot]]


def _claim(robot: str, moments: Sequence[Moment], start_from_body: Pose2) -> Claim:
    return Claim(start_from_body, hypotheses_of(pairings_of(robot, moments), start_from_body))


def _weighed(claim: Claim, moments: Sequence[Moment], field: MapField) -> Claim:
    """Return the claim with what the map says to it: the mean over moments, as they show the same things."""
    if not claim.hypotheses:
        return claim
    nats = np.zeros(len(claim.hypotheses))
    for moment in moments:
        poses = np.array([each.arena_from_start @ moment.start_from_body for each in claim.hypotheses])
        nats += match_nats(base_lines(moment.local_map), poses, field) / len(moments)
    weighed = [each._replace(evidence=each.evidence + more) for each, more in zip(claim.hypotheses, nats.tolist(), strict=True)]
    return claim._replace(hypotheses=sorted(weighed, key=lambda each: -each.evidence))


def _join(robot: str, arena_from_start: Pose2, moments: Sequence[Moment]) -> Join:
    last = moments[-1]
    found = Belief(arena_from_start @ last.start_from_body, LOOSE)
    ties = [tie for moment in moments for tie in _ties(robot, arena_from_start, moment)]
    return Join(robot, last.local_map.stamp_ns, found, ties)


def _ties(robot: str, arena_from_start: Pose2, moment: Moment) -> Iterator[Tie]:
    """Yield the sightings of a moment that show the robot, or robots that have a place to it, if it was where it is found to be."""
    own = Belief(arena_from_start @ moment.start_from_body, WELL_KNOWN)
    others = {other: Belief(pose, WELL_KNOWN) for other, pose in moment.robots.items()}
    for match in associate(moment.local_map.sightings, own, others):
        yield Tie(moment.local_map, match.robot, match.sighting)
    for view in moment.views:
        seeker = {robot: Belief(arena_from_start @ view.start_from_seeker, WELL_KNOWN)}
        for match in associate(view.strangers, Belief(view.arena_from_body, WELL_KNOWN), seeker):
            yield Tie(view.local_map, robot, match.sighting)
