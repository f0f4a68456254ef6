"""The map server's step: the local maps of one moment go in, everybody's pose and the changes of the map come out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from mapserver.batching import Batch
from mapserver.config import RobotSettings, starts_of
from mapserver.formation.floor import Floor
from mapserver.mapping.belief import Belief
from mapserver.mapping.bodies import Body
from mapserver.mapping.floor.grid import CELL_M
from mapserver.mapping.floor.overlay import Overlay
from mapserver.mapping.joining.seekers import Seekers
from mapserver.mapping.poses.pose_graph import Extent, PoseGraph
from mapserver.mapping.poses.scan import Rough, Standing
from mapserver.mapping.poses.scan_ties import ScanTies
from mapserver.mapping.poses.solver import Effort, Solver
from mapserver.mapping.poses.ties import Ties, without_names
from mapserver.mapping.things.movers import MoverWatch
from mapserver.mapping.things.tracker import ThingTracker
from protocol.fields import Packed, covariance_tuple, pose_tuple
from protocol.geometry import Array, Pose2
from protocol.messages import LocalMap, MapObject, MapTile, MapUpdate, Poses, RobotPose, Trajectories, Trajectory
from protocol.stage_clock import StageClock


class Merged(NamedTuple):
    """What one step has to tell."""

    poses: Poses
    update: MapUpdate


class _PlacedView(NamedTuple):
    """A local map, where its sender stood, and the bodies of the others."""

    local_map: LocalMap
    arena_from_body: Pose2
    bodies: list[Body]


class MapPipeline:
    """Holds pose graph, grid and things; `step` batches in the order of their stamps."""

    def __init__(
        self, robots: Sequence[RobotSettings], clock: StageClock, effort: Effort | None = None, extent: Extent | None = None
    ) -> None:
        """Begin with every robot at its start and nothing known of the floor."""
        self._radii_m = {robot.name: robot.body_radius_m for robot in robots}
        self._robots = sorted(self._radii_m)
        self._graph = PoseGraph(starts_of(robots), Solver(effort), extent)
        self._ties = Ties(self._graph, self._robots)
        self._scan_ties = ScanTies(self._graph)
        self._seekers = Seekers()
        self._overlay = Overlay()
        self._things = ThingTracker(self._overlay)
        self._movers = MoverWatch()
        self._objects: tuple[MapObject, ...] = ()
        self._rough: list[Rough] = []  # the same things, as the next step goes by them
        self._clock = clock
        self._steps = 0
        self._stamp_ns = 0

    def step(self, batch: Batch) -> Merged:
        """Merge a batch and return poses and map as of its stamp, from nothing captured later."""
        with self._clock.stage("associate"):
            self._extend_paths(batch.local_maps)
            self._ties.tie(batch.local_maps)
            self._tie_scans(batch.local_maps)
            self._let_join(batch)
        with self._clock.stage("graph"):
            self._graph.update()
            beliefs = self._graph.beliefs(batch.stamp_ns)
        views, bodies = self._views(batch), self._bodies(batch.stamp_ns)
        for view in views:
            with self._clock.stage("objects"):
                missed = self._things.observe(*view)
                self._movers.observe(*view)
            with self._clock.stage("overlay"):
                self._overlay.integrate(*view, missed)
        with self._clock.stage("objects"):
            self._things.clear(bodies)
            self._things.fit()
            shown, last_beliefs = self._things.shown(), self._graph.last_beliefs()
            self._objects, self._rough = tuple(thing.as_object(last_beliefs) for thing in shown), [thing.rough() for thing in shown]
        with self._clock.stage("overlay"):
            self._overlay.clear(bodies)
            tiles = self._overlay.take_changes([thing.corners_m for thing in self._rough])
        return self._merged(batch.stamp_ns, beliefs, tiles)

    def snapshot(self) -> MapUpdate:
        """Return the whole map as of the last step."""
        return self._map_update(self._overlay.all_tiles())

    def floor(self) -> Floor:
        """Return the grid as of the last step, as one array."""
        return Floor(*self._overlay.cells(), CELL_M)

    def moving(self, stamp_ns: int) -> list[Array]:
        """Return the footprints, (n, 2) [m; arena] each, of what moves and is no robot."""
        return self._movers.footprints(stamp_ns)

    def trajectories(self) -> Trajectories:
        """Return all paths, smoothed by everything that is known by now."""
        return Trajectories(robots=tuple(self._trajectory(robot) for robot in self._robots))

    def _extend_paths(self, local_maps: Sequence[LocalMap]) -> None:
        """Extend all paths; that of a robot that was lifted ends, and a new one begins, with no place but what its floor tells."""
        for local_map in local_maps:
            if self._graph.tells_of_lift(local_map) or self._ties.lifts.take_lifted(local_map.robot):
                self._graph.lose(local_map.robot)
            self._graph.add(local_map)
            self._graph.place_by_floor(local_map)

    def _tie_scans(self, local_maps: Sequence[LocalMap]) -> None:
        """Tie robots that know their place by what stands around them, as far as the map knew it after the last step."""
        standing = Standing(self._rough)
        for local_map in local_maps:
            if local_map.regions and self._knows_its_place(local_map.robot):
                self._scan_ties.tie(local_map, standing, self._bodies(local_map.stamp_ns, besides=local_map.robot))

    def _let_join(self, batch: Batch) -> None:
        """Enter robots that have found their place by what nobody named; Ties enters those that need no more than names."""
        self._seekers.note([without_names(local_map) for local_map in batch.local_maps], self._graph)
        while (join := self._seekers.joins(batch.stamp_ns, self._graph, self._overlay.cells)) is not None:
            self._graph.place(join.robot, join.stamp_ns, join.found)
            for tie in join.ties:
                self._graph.see(*tie)
            self._graph.update()

    def _views(self, batch: Batch) -> list[_PlacedView]:
        """Return the local maps that show something, of robots that know where they are."""
        return [self._placed(each) for each in batch.local_maps if self._knows_its_place(each.robot) and _shows_anything(each)]

    def _knows_its_place(self, robot: str) -> bool:
        return self._graph.has_place(robot) and not self._graph.is_searching(robot) and not self._ties.lifts.is_doubted(robot)

    def _placed(self, local_map: LocalMap) -> _PlacedView:
        pose = self._graph.belief(local_map.robot, local_map.stamp_ns).arena_from_body
        return _PlacedView(local_map, pose, self._bodies(local_map.stamp_ns, besides=local_map.robot))

    def _bodies(self, stamp_ns: int, besides: str = "") -> list[Body]:
        """Return the bodies of all robots that have been heard of, but for one."""
        heard = [robot for robot in self._robots if robot != besides and self._graph.is_placed(robot)]
        return [Body.of(self._graph.belief(robot, stamp_ns), self._radii_m[robot]) for robot in heard]

    def _merged(self, stamp_ns: int, beliefs: Mapping[str, Belief], tiles: tuple[MapTile, ...]) -> Merged:
        robots = tuple(_robot_pose(robot, belief) for robot, belief in beliefs.items())
        self._stamp_ns = stamp_ns
        merged = Merged(Poses(seq=self._steps, stamp_ns=stamp_ns, robots=robots, seekers=self._graph.seekers()), self._map_update(tiles))
        self._steps += 1
        return merged

    def _map_update(self, tiles: tuple[MapTile, ...]) -> MapUpdate:
        return MapUpdate(seq=self._steps, stamp_ns=self._stamp_ns, cell_m=CELL_M, tiles=tiles, objects=self._objects)

    def _trajectory(self, robot: str) -> Trajectory:
        stamps_ns, poses = self._graph.trajectory(robot)
        return Trajectory(robot=robot, stamps_ns=Packed.of(stamps_ns, "i8"), arena_from_body=Packed.of(poses, "f8"))


def _shows_anything(local_map: LocalMap) -> bool:
    return local_map.floor_range_m > 0.0 or bool(local_map.regions)


def _robot_pose(robot: str, belief: Belief) -> RobotPose:
    return RobotPose(
        robot=robot,
        arena_from_body=pose_tuple(belief.arena_from_body),
        covariance=covariance_tuple(belief.covariance),
        predicted=belief.predicted,
    )
