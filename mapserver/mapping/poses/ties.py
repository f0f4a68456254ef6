"""What sightings tie in the pose graph: robots, told apart where nobody names them, landmarks, and who finds its place by them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from mapserver.mapping.belief import VAGUE, Belief
from mapserver.mapping.poses.association import associate
from mapserver.mapping.poses.lifting import LiftWatch, Look
from mapserver.mapping.poses.pose_graph import PoseGraph
from mapserver.mapping.poses.strangers import Strangers
from protocol.messages import LocalMap, Sighting


class Ties:
    """Ties local maps that the graph has taken, in the order in which they came."""

    def __init__(self, graph: PoseGraph, robots: Sequence[str]) -> None:
        """Tie robots of these names; a sighting that names another robot ties nothing."""
        self._graph, self._robots = graph, robots
        self._strangers = Strangers()
        self.lifts = LiftWatch()

    def tie(self, local_maps: Sequence[LocalMap]) -> None:
        """Tie what the robots of one batch have sighted, place those whose place is certain by now, and watch for lifted ones."""
        looks: list[Look] = []
        for local_map in local_maps:
            if not self._graph.has_place(local_map.robot):
                self._strangers.hear(local_map)
            for sighting in local_map.sightings:
                self._tie_named(local_map, sighting)
            looks += self._tie_robots(local_map)
        if local_maps:
            self.lifts.note(max(local_map.stamp_ns for local_map in local_maps), looks)
        for robot in sorted({local_map.robot for local_map in local_maps}):
            if not self._graph.has_place(robot):
                self._find(robot)

    def _tie_named(self, local_map: LocalMap, sighting: Sighting) -> None:
        """Tie a landmark; let a sighting wait that names a robot without a place, or is the sighting of one."""
        identity = sighting.identity
        is_robot = identity.kind == "robot" and identity.name in self._robots
        if identity.kind == "landmark" and self._graph.has_place(local_map.robot):
            self._graph.see_landmark(local_map, sighting)
        elif identity.kind == "landmark" or (is_robot and not self._both_placed(local_map, sighting)):
            self._strangers.keep(local_map, sighting)

    def _tie_robots(self, local_map: LocalMap) -> Iterator[Look]:
        """Tie the sightings of other robots; yield the look of a robot that has a place, and is not searched for."""
        beliefs = self._graph.beliefs(local_map.stamp_ns)
        observer = beliefs.pop(local_map.robot, None)
        if observer is None:
            return
        matches = associate(local_map.sightings, observer, beliefs)
        for match in matches:
            self._graph.see(local_map, match.robot, match.sighting)
        if not self._graph.is_searching(local_map.robot):
            yield Look(local_map, matches)

    def _both_placed(self, local_map: LocalMap, sighting: Sighting) -> bool:
        return self._graph.has_place(local_map.robot) and self._graph.has_place(sighting.identity.name)

    def _find(self, robot: str) -> None:
        found = self._strangers.find(robot, self._graph)
        if found is None:
            return
        self._graph.place(robot, found.stamp_ns, Belief(found.arena_from_body, VAGUE))
        for untied in self._strangers.release(robot):
            if untied.sighting.identity.kind == "robot" and self._both_placed(*untied):
                self._graph.see(untied.local_map, untied.sighting.identity.name, untied.sighting)
            else:
                self._tie_named(*untied)


def without_names(local_map: LocalMap) -> LocalMap:
    """Return a local map with those sightings alone that nobody named."""
    anonymous = tuple(sighting for sighting in local_map.sightings if sighting.identity.kind == "none")
    return local_map if len(anonymous) == len(local_map.sightings) else local_map.model_copy(update={"sightings": anonymous})
