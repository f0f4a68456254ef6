"""Where the robot is in the arena."""

from __future__ import annotations

import math

import numpy as np
import pytest

from agent.control.course import Course
from agent.slam.odometry import WheelGeometry
from protocol.geometry import Array, Pose2

MS = 1_000_000


@pytest.fixture
def course() -> Course:
    return Course(WheelGeometry(radius_m=0.03, base_m=0.12))


def rolled(distance_m: float) -> Array:
    return np.full(2, distance_m / 0.03)


def test_before_the_first_frame_nothing_is_known(course: Course) -> None:
    assert course.odom_from_body(100 * MS, rolled(0.0)) is None
    course.note_pose(100 * MS, rolled(0.0), Pose2(1.0, 2.0, 3.0))
    assert course.arena_from_body(Pose2.identity()) is None


def test_the_wheels_carry_the_last_frame_before_a_stamp_on(course: Course) -> None:
    course.note_frame(100 * MS, rolled(0.5), Pose2(0.1, 0.0, math.pi / 2))
    course.note_frame(200 * MS, rolled(0.6), Pose2(9.0, 9.0, 0.0))
    assert course.odom_from_body(150 * MS, rolled(0.55)) == pytest.approx((0.1, 0.05, math.pi / 2))
    assert course.odom_from_body(250 * MS, rolled(0.65)) == pytest.approx((9.05, 9.0, 0.0))


def test_the_servers_pose_for_a_stamp_gone_by_is_carried_on_by_odometry(course: Course) -> None:
    course.note_frame(100 * MS, rolled(0.0), Pose2.identity())
    course.note_frame(200 * MS, rolled(0.1), Pose2(0.1, 0.0, 0.0))
    course.note_pose(100 * MS, rolled(0.0), Pose2(1.0, 1.0, math.pi / 2))
    now = course.odom_from_body(200 * MS, rolled(0.1))
    assert now is not None
    assert course.arena_from_body(now) == pytest.approx((1.0, 1.1, math.pi / 2))


def test_a_pose_for_a_stamp_before_all_frames_changes_nothing(course: Course) -> None:
    course.note_frame(100 * MS, rolled(0.0), Pose2.identity())
    course.note_pose(100 * MS, rolled(0.0), Pose2(1.0, 1.0, 0.0))
    course.note_pose(50 * MS, rolled(0.0), Pose2(7.0, 7.0, 0.0))
    assert course.arena_from_body(Pose2.identity()) == pytest.approx((1.0, 1.0, 0.0))
