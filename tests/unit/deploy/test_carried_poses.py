"""Where a robot knows itself to be when poses do not reach it."""

from __future__ import annotations

import math

import pytest

from deploy.carried_poses import CarriedPoses
from protocol.fields import pose_tuple
from protocol.geometry import Pose2
from protocol.messages import Poses, RobotPose
from tests.unit.mapserver.worlds import local_map

ARENA_FROM_ODOM = Pose2(1.0, 2.0, math.pi / 2)


def told(stamp_ns: int, odom: Pose2) -> Poses:
    pose = RobotPose(robot="r1", arena_from_body=pose_tuple(ARENA_FROM_ODOM @ odom), covariance=(0.0,) * 6, predicted=False)
    return Poses(seq=0, stamp_ns=stamp_ns, robots=(pose,))


def test_the_last_pose_is_carried_on_by_the_robots_own_odometry() -> None:
    carried = CarriedPoses()
    before, now = (local_map("r1", seq, odom=Pose2(0.1 * seq, 0.0, 0.0)) for seq in (3, 5))
    carried.hear([before, now])
    carried.tell(told(before.stamp_ns, Pose2(0.3, 0.0, 0.0)))
    assert carried.at("r1", now.stamp_ns) == pytest.approx((1.0, 2.5, math.pi / 2))


def test_a_robot_that_no_pose_has_reached_knows_nothing() -> None:
    carried = CarriedPoses()
    seen = local_map("r1", 0)
    carried.hear([seen])
    assert carried.at("r1", seen.stamp_ns) is None
    assert carried.at("r2", seen.stamp_ns) is None


def test_a_restarted_agent_has_to_be_told_anew() -> None:
    carried = CarriedPoses()
    before, after = local_map("r1", 0), local_map("r1", 0, epoch=1, stamp_ns=10**10)
    carried.hear([before])
    carried.tell(told(before.stamp_ns, Pose2.identity()))
    carried.hear([after])
    assert carried.at("r1", after.stamp_ns) is None
