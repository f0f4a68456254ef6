"""The swarm's pose graph: every robot's path in the arena, from odometry, places recognised and robots seeing each other.

Variables are Pose2, one for each robot and local map, Point2, one for each landmark that somebody sees and names, and Pose2 again, one for
each reference: where a local map was captured whose base lines are kept for others to be matched with.
All state is causal: a belief rests on nothing but the local maps added so far.

The oldest poses leave the graph where there are too many, and stay in the smoothed paths at their last estimates.
A robot of which nobody knows where it is has no place: its path is kept as a chain of its own (odometry.py) until it is placed.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Mapping
from dataclasses import dataclass

import gtsam
import numpy as np
from numpy.typing import NDArray

from mapserver.mapping.belief import VAGUE, Belief, Twist, extrapolate
from mapserver.mapping.covariance import made_definite
from mapserver.mapping.poses.association import sighted_point
from mapserver.mapping.poses.factor_noise import motion_within, robust, robust_sighting
from mapserver.mapping.poses.odometry import LEAST_MOTION_VARIANCE, STANDING, Chain, interpolated, motion
from mapserver.mapping.poses.sighting_noise import SightingLedger
from mapserver.mapping.poses.solver import Solver, from_gtsam, to_gtsam
from mapserver.mapping.poses.track import Node, Start, Track
from protocol.fields import covariance_matrix
from protocol.geometry import Array, Pose2
from protocol.messages import LocalMap, Revisit, Sighting

MOST_GAP_S = 0.3  # between two poses on a path that goes on
MAX_STAMP_GAP_S = 0.06  # between a sighting and the nearest pose of the robot that it shows
PAST_SIGMA = np.array([0.01, 0.01, 0.01])  # of a pose that has left the graph, besides what the rest has in common with it [m, m, rad]
_FIRST_LANDMARK_KEY, _FIRST_REFERENCE_KEY = 1 << 62, 3 << 61  # beyond all robots'


@dataclass(frozen=True)
class Extent:
    """How many poses of all robots the graph holds; where there are more, the oldest are marginalised until so many are kept.

    What is kept is solved anew then, which holds setpoints up: for less time than robots drive on without any.
    """

    most_poses: int = 6_000
    kept_poses: int = 4_500


class PoseGraph:
    """Holds all robots' paths. `add` local maps, `see` and `place` robots, then `update`; read beliefs and trajectories at any time."""

    def __init__(self, starts: Mapping[str, Start | None], solver: Solver | None = None, extent: Extent | None = None) -> None:
        """Begin with every robot at its start, or without a place where that is None; robots are numbered in the order of their names."""
        self._solver = solver or Solver()
        self._extent = extent or Extent()
        self._factors = gtsam.NonlinearFactorGraph()
        self._values = gtsam.Values()
        self._ledger = SightingLedger()
        self._landmarks: dict[str, int] = {}  # keys, by name
        self._references = 0  # how many there are
        self._indices = {robot: index for index, robot in enumerate(sorted(starts))}
        self._tracks = {robot: Track(index, start.belief()) for robot, index in self._indices.items() if (start := starts[robot])}
        self._chains = {robot: Chain() for robot in self._indices if robot not in self._tracks}  # of those without a place

    def add(self, local_map: LocalMap) -> None:
        """Extend the robot's path to the local map's stamp, which must be newer than its last one."""
        if local_map.robot in self._chains:
            self._chains[local_map.robot].add(local_map)
            return
        track = self._tracks[local_map.robot]
        if track.last is None:
            self._begin(track, local_map)
        else:
            self._extend(track, track.last, local_map)
        track.last = local_map
        self._values.insert(track.newest_key(), to_gtsam(track.belief.arena_from_body))
        for revisit in local_map.revisits:
            self._tie_revisit(track, revisit)

    def see(self, local_map: LocalMap, target: str, sighting: Sighting) -> None:
        """Tie an added local map's pose to the target's pose of (nearly) the same stamp; who has none, or no place, ties nothing."""
        observer, seen = self._node(local_map.robot, local_map.stamp_ns), self._node(target, local_map.stamp_ns)
        if observer is None or seen is None or seen.gap_s > MAX_STAMP_GAP_S:
            return
        pair = (local_map.robot, target)
        covariance = self._ledger.covariance(pair, self._pose(observer.key), self._pose(seen.key), sighting)
        if covariance is None:
            return
        covariance = covariance + motion_within(seen.gap_s, self._tracks[target].twist, sighting.range_m)
        bearing, noise = gtsam.Rot2(sighting.bearing_rad), robust_sighting(covariance)
        self._factors.add(gtsam.BearingRangeFactorPose2(observer.key, seen.key, bearing, sighting.range_m, noise))

    def see_landmark(self, local_map: LocalMap, sighting: Sighting) -> None:
        """Tie an added local map's pose to the landmark that the sighting names; the first to see it tells where it is."""
        name = sighting.identity.name
        observer = self._key_at(local_map.robot, local_map.stamp_ns)
        if observer is None:
            return
        pose = self._pose(observer)
        if name not in self._landmarks:
            self._landmarks[name] = _FIRST_LANDMARK_KEY + len(self._landmarks)
            self._values.insert(self._landmarks[name], pose.apply(sighted_point(sighting)))
        key, place = self._landmarks[name], self._landmark_place(name)
        covariance = self._ledger.covariance(
            (local_map.robot, f"landmark {name}"), pose, Pose2(float(place[0]), float(place[1]), 0.0), sighting
        )
        if covariance is not None:
            bearing, noise = gtsam.Rot2(sighting.bearing_rad), robust_sighting(covariance)
            self._factors.add(gtsam.BearingRangeFactor2D(observer, key, bearing, sighting.range_m, noise))

    def add_reference(self, local_map: LocalMap, covariance: Array) -> int:
        """Keep the pose of an added local map, known to this covariance, (3, 3) in the body frame, by what it shows; return its number."""
        number, key = self._references, self._tracks[local_map.robot].newest_key()
        self._references += 1
        self._values.insert(_FIRST_REFERENCE_KEY + number, to_gtsam(self._pose(key)))
        noise = gtsam.noiseModel.Gaussian.Covariance(covariance)
        self._factors.add(gtsam.BetweenFactorPose2(key, _FIRST_REFERENCE_KEY + number, gtsam.Pose2(), noise))
        return number

    def tie_to_reference(self, local_map: LocalMap, number: int, reference_from_body: Pose2, covariance: Array) -> None:
        """Tie an added local map's pose to a reference by what both show, known to this covariance, (3, 3) in the body frame."""
        key = self._tracks[local_map.robot].newest_key()
        between = to_gtsam(reference_from_body)
        self._factors.add(gtsam.BetweenFactorPose2(_FIRST_REFERENCE_KEY + number, key, between, robust(covariance)))

    def place(self, robot: str, stamp_ns: int, found: Belief) -> None:
        """Enter a robot without a place, and its path so far, where it is `found` to be at the stamp of one of its added local maps.

        The covariance of `found` must hold nothing of sightings that it is to be tied by as well.
        """
        chain = self._chains.pop(robot)
        fixed = chain.stamps_ns.index(stamp_ns)
        track = self._tracks.setdefault(robot, Track(self._indices[robot], found))
        first = len(track.stamps_ns)
        arena_from_start = found.arena_from_body @ chain.start_from_body[fixed].inverse()
        for number, node_ns in enumerate(chain.stamps_ns):
            track.stamps_ns.append(node_ns)
            self._values.insert(track.newest_key(), to_gtsam(arena_from_start @ chain.start_from_body[number]))
            if number:
                self._tie_motion(track, chain.twists[number])
        noise = gtsam.noiseModel.Gaussian.Covariance(found.covariance)
        self._factors.add(gtsam.PriorFactorPose2(track.key(first + fixed), to_gtsam(found.arena_from_body), noise))
        track.belief, track.twist, track.last = found, chain.twists[-1], chain.last
        for twist in chain.twists[fixed + 1 :]:
            track.belief = track.belief.moved(twist.body_from_next, twist.covariance)

    def lose(self, robot: str) -> None:
        """End the path of a robot: it is elsewhere, nobody knows where. Its next local map begins a chain."""
        self._chains[robot] = Chain()
        if robot in self._tracks:
            self._tracks[robot].searched_ns = None
        self._ledger.forget(robot)

    def tells_of_lift(self, local_map: LocalMap) -> bool:
        """Tell whether the robot was lifted and put down elsewhere after its last local map, which this one follows."""
        path = self._chains.get(local_map.robot) or self._tracks[local_map.robot]
        return path.last is not None and path.last.epoch == local_map.epoch and path.last.lifts != local_map.lifts

    def place_by_floor(self, local_map: LocalMap) -> None:
        """Enter a robot without a place by the floor in its newest local map, where that is recognised from when it had one."""
        track = self._tracks.get(local_map.robot)
        if track is None or self.has_place(local_map.robot):
            return
        for revisit in local_map.revisits:
            then = self._pose_then(track, revisit.stamp_ns)
            if then is not None:
                self.place(local_map.robot, local_map.stamp_ns, Belief(then @ Pose2(*revisit.then_from_body), VAGUE))
                self._tie_revisit(track, revisit)
                return

    def update(self) -> dict[str, Belief]:
        """Solve with all that was added since the last call and return where each placed robot is at its own newest stamp."""
        self._solver.update(self._factors, self._values)
        self._factors = gtsam.NonlinearFactorGraph()
        self._values = gtsam.Values()
        for track in self._tracks.values():
            if track.stamps_ns:
                track.belief = self._solver.belief(track.newest_key())
                track.end_search()
        if sum(len(track.stamps_ns) for track in self._tracks.values()) > self._extent.most_poses:
            self._let_oldest_leave()
        return self.last_beliefs()

    def belief(self, robot: str, stamp_ns: int) -> Belief:
        """Return where a robot that has a place is at `stamp_ns`: its pose of then, else its newest, carried forward if that is older."""
        track = self._tracks[robot]
        if track.twist is None or not track.stamps_ns:
            return track.belief
        key = track.key_at(stamp_ns)
        if key is not None and key != track.newest_key() and self._solver.has(key):
            return self._solver.belief(key)
        return extrapolate(track.belief, track.twist, (stamp_ns - track.stamps_ns[-1]) * 1e-9)

    def beliefs(self, stamp_ns: int) -> dict[str, Belief]:
        """Return where the robots that have a place are at a stamp, in the order of their names."""
        return {robot: self.belief(robot, stamp_ns) for robot in self._indices if self.has_place(robot)}

    def last_beliefs(self) -> dict[str, Belief]:
        """Return where every robot that has ever had a place was last believed to be."""
        return {robot: track.belief for robot, track in self._tracks.items()}

    def pose(self, robot: str, stamp_ns: int) -> Pose2 | None:
        """Return the pose of a robot that has a place at a stamp gone by or near; None where it was not heard of then."""
        node, track = self._node(robot, stamp_ns), self._tracks.get(robot)
        if node is None or track is None or track.twist is None or node.gap_s > MOST_GAP_S:
            return None
        return interpolated(track.stamps_ns, lambda number: self._pose(track.key(number)), track.twist, stamp_ns)

    def chain(self, robot: str) -> Chain:
        """Return the path so far of a robot without a place."""
        return self._chains[robot]

    def seekers(self) -> tuple[str, ...]:
        """Return the robots without a place, in the order of their names."""
        return tuple(sorted(self._chains))

    def has_place(self, robot: str) -> bool:
        """Tell whether it is known where the robot is, or at least where it was set down."""
        return robot not in self._chains

    def is_placed(self, robot: str) -> bool:
        """Tell whether the robot has a place and has sent a local map yet."""
        return self.has_place(robot) and bool(self._tracks[robot].stamps_ns)

    def pose_at(self, robot: str, stamp_ns: int) -> Pose2 | None:
        """Return a placed robot's pose of exactly this stamp, if it has one."""
        key = self._key_at(robot, stamp_ns) if robot in self._indices else None
        return None if key is None else self._pose(key)

    def landmark(self, name: str) -> Array | None:
        """Return where a landmark that was seen is, shape (2,) [m; arena]."""
        return self._landmark_place(name) if name in self._landmarks else None

    def reference(self, number: int) -> Pose2:
        """Return where a reference is."""
        return self._pose(_FIRST_REFERENCE_KEY + number)

    def is_searching(self, robot: str) -> bool:
        """Tell whether the robot was set down no one knows where exactly, or its agent began anew, and others have yet to tell where."""
        return self.has_place(robot) and self._tracks[robot].searched_ns is not None

    def trajectory(self, robot: str) -> tuple[NDArray[np.int64], Array]:
        """Return the smoothed path: stamps, shape (n,) [ns], and poses, shape (n, 3) [m, m, rad; arena]; none without a place."""
        track = self._tracks.get(robot)
        if track is None:
            return np.empty(0, dtype=np.int64), np.empty((0, 3))
        return track.trajectory(self._solver.pose)

    def _begin(self, track: Track, local_map: LocalMap) -> None:
        """Fix the first pose: the start, moved on by what the agent has driven before this first local map."""
        driven = made_definite(covariance_matrix(local_map.motion_covariance) * local_map.seq, LEAST_MOTION_VARIANCE)
        track.belief = track.belief.moved(Pose2(*local_map.odom_from_body), driven)._replace(predicted=False)
        track.twist = STANDING
        track.stamps_ns.append(local_map.stamp_ns)
        track.searched_ns = None if track.is_well_known() else local_map.stamp_ns
        noise = gtsam.noiseModel.Gaussian.Covariance(track.belief.covariance)
        self._factors.add(gtsam.PriorFactorPose2(track.newest_key(), to_gtsam(track.belief.arena_from_body), noise))

    def _extend(self, track: Track, last: LocalMap, local_map: LocalMap) -> None:
        twist = motion(last, local_map)
        if local_map.epoch != last.epoch:
            track.searched_ns = local_map.stamp_ns
            self._ledger.forget(local_map.robot)
        track.belief = track.belief.moved(twist.body_from_next, twist.covariance)
        track.twist = twist
        track.stamps_ns.append(local_map.stamp_ns)
        self._tie_motion(track, twist)

    def _let_oldest_leave(self) -> None:
        """Marginalise the oldest poses of all robots, so many that as many remain as are to be kept, but never a robot's newest."""
        since_ns = sorted(stamp_ns for track in self._tracks.values() for stamp_ns in track.stamps_ns)[-self._extent.kept_poses]
        leaving: list[int] = []
        for track in self._tracks.values():
            if track.stamps_ns:
                older = bisect_left(track.stamps_ns, since_ns, hi=len(track.stamps_ns) - 1)
                leaving += track.leave(older, self._solver.pose)
        self._solver.marginalise(leaving)

    def _tie_motion(self, track: Track, twist: Twist) -> None:
        """Tie the newest of a track's variables to the one before."""
        noise = gtsam.noiseModel.Gaussian.Covariance(twist.covariance)
        key = track.newest_key()
        self._factors.add(gtsam.BetweenFactorPose2(key - 1, key, to_gtsam(twist.body_from_next), noise))

    def _tie_revisit(self, track: Track, revisit: Revisit) -> None:
        """Tie the newest of a track's variables to the pose of an earlier stamp, if there is one: its local map may have been lost.

        A pose that has left the graph stays where it was.
        """
        key, then_key, past = track.newest_key(), track.key_at(revisit.stamp_ns), track.past.pose(revisit.stamp_ns)
        between = Pose2(*revisit.then_from_body)
        covariance = made_definite(covariance_matrix(revisit.covariance), LEAST_MOTION_VARIANCE)
        if past is not None:
            self._factors.add(gtsam.PriorFactorPose2(key, to_gtsam(past @ between), robust(covariance + np.diag(PAST_SIGMA**2))))
        elif then_key not in (None, key):
            self._factors.add(gtsam.BetweenFactorPose2(then_key, key, to_gtsam(between), robust(covariance)))

    def _pose_then(self, track: Track, stamp_ns: int) -> Pose2 | None:
        """Return a track's pose of exactly this stamp, as it is believed to have been; None where there is none."""
        key = track.key_at(stamp_ns)
        return track.past.pose(stamp_ns) if key is None else self._pose(key)

    def _key_at(self, robot: str, stamp_ns: int) -> int | None:
        return self._tracks[robot].key_at(stamp_ns) if self.has_place(robot) else None

    def _node(self, robot: str, stamp_ns: int) -> Node | None:
        return Node.of(self._tracks[robot], stamp_ns) if self.has_place(robot) else None

    def _pose(self, key: int) -> Pose2:
        return from_gtsam(self._values.atPose2(key)) if self._values.exists(key) else self._solver.pose(key)

    def _landmark_place(self, name: str) -> Array:
        key = self._landmarks[name]
        return np.asarray(self._values.atPoint2(key) if self._values.exists(key) else self._solver.point(key))
