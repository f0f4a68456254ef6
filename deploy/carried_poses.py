"""Where robots know themselves to be: by the last pose that reached them, carried on by their own odometry."""

from __future__ import annotations

from collections.abc import Iterable

from protocol.fields import PoseTuple, pose_tuple
from protocol.geometry import Pose2
from protocol.messages import LocalMap, Poses

KEPT = 64  # local maps of each robot


class CarriedPoses:
    """Hears the robots' local maps, and the poses that reached them."""

    def __init__(self) -> None:
        self._odom_from_body: dict[str, dict[int, Pose2]] = {}  # by robot and stamp
        self._arena_from_odom: dict[str, Pose2] = {}
        self._epochs: dict[str, int] = {}

    def hear(self, local_maps: Iterable[LocalMap]) -> None:
        """Take note of the robots' own odometry."""
        for local_map in local_maps:
            if self._epochs.setdefault(local_map.robot, local_map.epoch) != local_map.epoch:
                self._epochs[local_map.robot] = local_map.epoch
                self._odom_from_body.pop(local_map.robot, None)
                self._arena_from_odom.pop(local_map.robot, None)
            own = self._odom_from_body.setdefault(local_map.robot, {})
            own[local_map.stamp_ns] = Pose2(*local_map.odom_from_body)
            while len(own) > KEPT:
                del own[min(own)]

    def has_heard(self, robots: Iterable[str], stamp_ns: int) -> bool:
        """Tell whether there is a local map of this stamp by all these robots."""
        return all(stamp_ns in self._odom_from_body.get(robot, {}) for robot in robots)

    def tell(self, poses: Poses) -> None:
        """Take poses that have arrived."""
        for pose in poses.robots:
            odom_from_body = self._odom_from_body.get(pose.robot, {}).get(poses.stamp_ns)
            if odom_from_body is not None:
                self._arena_from_odom[pose.robot] = Pose2(*pose.arena_from_body) @ odom_from_body.inverse()

    def at(self, robot: str, stamp_ns: int) -> PoseTuple | None:
        """Return arena_from_body of a robot at the stamp of one of its local maps; None where it cannot know."""
        arena_from_odom = self._arena_from_odom.get(robot)
        odom_from_body = self._odom_from_body.get(robot, {}).get(stamp_ns)
        if arena_from_odom is None or odom_from_body is None:
            return None
        return pose_tuple(arena_from_odom @ odom_from_body)
