"""Writes down a run as it is heard on the swarm's bus: live paths while it goes on, and at its end what map server and agents answer."""

from __future__ import annotations

import math
import time
from collections import Counter, defaultdict
from collections.abc import Collection, Sequence
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType
from typing import Self, TextIO, TypeVar

from agent.debug import PICTURES
from deploy.account import Heard
from deploy.carried_poses import CarriedPoses
from mapserver.export import write_geojson, write_grid
from protocol import topics
from protocol.bus import Bus
from protocol.errors import LinkError
from protocol.fields import Message, PoseTuple
from protocol.inbox import Arrived
from protocol.loss import Loss
from protocol.messages import AgentStatus, LocalMap, MotionVectors, RobotPose, ServerStatus, Trajectory

ANSWER_TIMEOUT_S = 30.0  # the smoothed paths are computed when they are asked for

ROBOTS_PATIENCE_S = 1.0  # a robot whose local map does not come meanwhile has gone

M = TypeVar("M", bound=Message)


class Recorder:
    """A client of the map server that fills a run's folder; it listens on the bus that it is given and starts no thread.

    A robot's live path has no line for a frame at which nobody knew its place: such frames are counted.
    """

    def __init__(self, swarm: Bus, out: Path, robots: Sequence[str], loss: Loss | None = None) -> None:
        """`loss` drops poses as they arrive: a robot then carries on its last one by its own odometry, and so does its live path."""
        self._swarm = swarm
        self._out = out
        self._robots = robots
        self._poses = swarm.inbox(topics.POSES, loss)
        self._carried, self._is_lossy = CarriedPoses(), loss is not None
        self._maps = swarm.inbox(topics.LOCAL_MAP)
        self._vectors = swarm.inbox(topics.MOTION_VECTORS)
        self._frame_bytes: defaultdict[str, Counter[int]] = defaultdict(Counter)  # by robot and stamp
        self._paths: dict[str, TextIO] = {}
        self._files = ExitStack()
        self.predicted = dict.fromkeys(robots, 0)  # live poses without a local map of their stamp
        self.unplaced = dict.fromkeys(robots, 0)  # frames for which a robot had no pose, as nobody knew its place
        self.joined_ns: dict[str, int] = {}  # stamp of each robot's first pose

    def __enter__(self) -> Self:
        """Open a file for every robot's live path."""
        folder = self._out / "trajectories"
        (folder / "smoothed").mkdir(parents=True)
        for robot in self._robots:
            self._paths[robot] = self._files.enter_context((folder / f"{robot}.tum").open("w", encoding="utf-8", buffering=1))
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        """Close the files."""
        self._files.close()

    def wait_for_poses(self, stamp_ns: int, fired: Collection[str], timeout_s: float) -> None:
        """Write the live poses of this stamp, for the robots that fired and have a place; LinkError where they do not come in time."""
        deadline_s = time.monotonic() + timeout_s
        self._hear_robots(stamp_ns, fired)
        while not self._write_poses_of(stamp_ns, fired):
            left_s = deadline_s - time.monotonic()
            if left_s <= 0.0:
                raise LinkError(f"the map server published no poses for stamp {stamp_ns} within {timeout_s:g} s")
            self._swarm.wait(left_s)

    def write_pictures(self, ending: str = "") -> None:
        """Ask every agent for all views of its last frame; one that has not had a usable frame yet answers none."""
        folder = self._out / "pictures"
        folder.mkdir(exist_ok=True)
        for view in PICTURES:
            for answer in self._swarm.ask(topics.AGENT_DEBUG, ANSWER_TIMEOUT_S, {"view": view}):
                (folder / f"{answer.robot}_{view}{ending}.png").write_bytes(answer.png)

    def write_results(self) -> None:
        """Write what is known after the last step: pictures, the map, the smoothed paths."""
        self.write_pictures("_end")
        self.write_map()
        self.write_smoothed()

    def write_map(self) -> None:
        """Ask for the whole map, and write it as polygons and as a grid."""
        snapshot = self._ask(topics.MAP_SNAPSHOT, "the map")
        write_geojson(snapshot, self._out / "map.geojson")
        write_grid(snapshot, self._out)

    def write_smoothed(self) -> None:
        """Ask for the paths after all data were in, and write them."""
        for path in self._ask(topics.TRAJECTORIES, "the smoothed paths").robots:
            (self._out / "trajectories" / "smoothed" / f"{path.robot}.tum").write_text(_tum(path), encoding="utf-8")

    def server_report(self) -> ServerStatus:
        """Ask the map server how it fares."""
        return self._ask(topics.SERVER_REPORT, "its report")

    def agent_reports(self) -> dict[str, AgentStatus]:
        """Ask all agents how they fare, and return their answers by name."""
        reports = {answer.robot: answer for answer in self._swarm.ask(topics.AGENT_REPORT, ANSWER_TIMEOUT_S)}
        if missing := sorted(set(self._robots) - reports.keys()):
            raise LinkError(f"{', '.join(missing)} did not answer when asked for a report")
        return reports

    def heard(self, robot: str) -> Heard:
        """Return what was heard of a robot so far; a frame's bytes are its local map and its motion vectors, encoded."""
        return Heard(self.predicted[robot], self.unplaced[robot], self.joined_ns.get(robot), list(self._frame_bytes[robot].values()))

    def _ask(self, query: topics.Query[M], what: str) -> M:
        answers = self._swarm.ask(query, ANSWER_TIMEOUT_S)
        if not answers:
            raise LinkError(f"the map server did not answer when asked for {what}")
        return answers[0]

    def _count_bytes(self) -> None:
        maps = self._maps.take_arrived()
        self._carried.hear(each.message for each in maps)
        arrived: list[Arrived[LocalMap] | Arrived[MotionVectors]] = [*maps, *self._vectors.take_arrived()]
        for message, _, length_bytes in arrived:
            self._frame_bytes[message.robot][message.stamp_ns] += length_bytes

    def _hear_robots(self, stamp_ns: int, fired: Collection[str]) -> None:
        """Where poses may be lost, hear first what carries them on: a local map may come here later than the poses that rest on it."""
        until_s = time.monotonic() + ROBOTS_PATIENCE_S
        self._count_bytes()
        while self._is_lossy and not self._carried.has_heard(fired, stamp_ns) and time.monotonic() < until_s:
            self._swarm.wait(ROBOTS_PATIENCE_S)
            self._count_bytes()

    def _write_poses_of(self, stamp_ns: int, fired: Collection[str]) -> bool:
        """Take what has arrived; return whether the poses of this stamp were among it."""
        self._count_bytes()
        for poses in self._poses.take():
            self._carried.tell(poses)
            if poses.stamp_ns == stamp_ns:
                seekers = set(fired) & set(poses.seekers)
                self._write_poses(stamp_ns, {pose.robot: pose for pose in poses.robots}, set(fired) - seekers)
                for robot in seekers:
                    self.unplaced[robot] += 1
                return True
        if any(poses.stamp_ns == stamp_ns for poses in self._poses.take_dropped()):
            self._write_carried_poses(stamp_ns, fired)
            return True
        return False

    def _write_poses(self, stamp_ns: int, poses: dict[str, RobotPose], fired: Collection[str]) -> None:
        if missing := sorted(set(fired) - poses.keys()):
            raise LinkError(f"the map server published no pose of {', '.join(missing)} for stamp {stamp_ns}")
        for robot in fired:
            self._paths[robot].write(tum_line(stamp_ns, poses[robot].arena_from_body))
            self.predicted[robot] += poses[robot].predicted
            self.joined_ns.setdefault(robot, stamp_ns)

    def _write_carried_poses(self, stamp_ns: int, fired: Collection[str]) -> None:
        """Write where the robots believe to be that the poses of a stamp have not reached."""
        for robot in fired:
            pose = self._carried.at(robot, stamp_ns)
            if pose is None:
                self.unplaced[robot] += 1
                continue
            self._paths[robot].write(tum_line(stamp_ns, pose))
            self.predicted[robot] += 1


def tum_line(stamp_ns: int, arena_from_body: PoseTuple) -> str:
    """Return one line of the TUM format: timestamp [s] x y z [m] qx qy qz qw; the stamp is exact to the nanosecond."""
    x_m, y_m, theta_rad = arena_from_body
    seconds, nanoseconds = divmod(stamp_ns, 1_000_000_000)
    qz, qw = math.sin(0.5 * theta_rad), math.cos(0.5 * theta_rad)
    return f"{seconds}.{nanoseconds:09d} {x_m:.9f} {y_m:.9f} 0 0 0 {qz:.9f} {qw:.9f}\n"


def _tum(path: Trajectory) -> str:
    stamps_ns, poses = path.stamps_ns.array(), path.arena_from_body.array()
    return "".join(tum_line(int(stamp), (float(x), float(y), float(t))) for stamp, (x, y, t) in zip(stamps_ns, poses, strict=True))
