"""Which drive order is due."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
import pytest

from agent.control.limits import DriveLimits
from agent.control.second_look import BACK_M, HELD_S
from agent.control.setpoints import FRESH_S
from agent.driving.driver_seat import BLIND_S, POSES_LIMIT_S, DriverSeat
from agent.driving.guard_pipe import DriveOrder
from agent.rig import Body
from agent.wheel_history import WheelHistory
from protocol.fields import pose_tuple
from protocol.geometry import Pose2
from protocol.messages import Poses, RobotPose
from tests.unit.agent.control.broadcasts import MS, broadcast
from tests.unit.agent.control.local_maps import box, local_map, region

BODY = Body(body_radius_m=0.075, body_height_m=0.3, wheel_base_m=0.12, wheel_radius_m=0.03)
WHEEL_RAD_S = 5.0  # of both wheels at 0.15 m/s


@dataclass
class Drive:
    """A seat whose world is told by the test: the robot goes straight on along x."""

    now_s: float = 50.0
    now_ms: int | None = 0
    x_m: float = 0.0
    seq: int = 0
    history: WheelHistory = field(default_factory=WheelHistory)

    def __post_init__(self) -> None:
        self.seat = DriverSeat("r1", BODY, DriveLimits(), 0.02, self.history, self._now_ns, lambda: self.now_s)

    def _now_ns(self) -> int | None:
        return None if self.now_ms is None else self.now_ms * MS

    def roll(self, stamp_ms: int, x_m: float) -> None:
        """Read the wheels at a stamp, at which the robot has come so far."""
        self.x_m, self.now_ms = x_m, stamp_ms
        self.history.add(np.array([stamp_ms * MS]), np.full((1, 2), x_m / BODY.wheel_radius_m), stamp_ms * MS)

    def look(self, stamp_ms: int, *boxes: tuple[float, float], dropped: bool = False) -> None:
        """See some boxes, by their places in the body's frame."""
        regions = [region(box(*place)) for place in boxes]
        odom_from_body = Pose2(self.x_m, 0.0, 0.0)
        seen = local_map(stamp_ms, regions, odom_from_body=odom_from_body, picture="dropped" if dropped else "used")
        self.seat.see(seen, self.history.angles_at(stamp_ms * MS))

    def locate(self, stamp_ms: int, arena_from_body: Pose2, *, predicted: bool = False) -> None:
        pose = RobotPose(robot="r1", arena_from_body=pose_tuple(arena_from_body), covariance=(0.0,) * 6, predicted=predicted)
        self.seat.locate(Poses(seq=0, stamp_ns=stamp_ms * MS, robots=(pose,)))

    def hear(self, stamp_ms: int, x_m: float, *, speed_m_s: float = 0.15, robot: str = "r1") -> None:
        self.seat.offer(broadcast(stamp_ms, self.seq, pose=(x_m, 0.0, 0.0), speed_m_s=speed_m_s, robot=robot), self.now_s)
        self.seq += 1

    def step(self, stamp_ms: int, x_m: float, *boxes: tuple[float, float], ahead_m: float = 0.0) -> DriveOrder | None:
        """Read the wheels, look, hear where the robot is, and that it should be there, or ahead of that, and go on."""
        self.roll(stamp_ms, x_m)
        self.look(stamp_ms, *boxes)
        self.locate(stamp_ms, Pose2(x_m, 0.0, 0.0))
        self.hear(stamp_ms, x_m + ahead_m)
        return self.seat.order()


def stands(order: DriveOrder | None) -> bool:
    return order is not None and (order.left_rad_s, order.right_rad_s) == (0.0, 0.0)


@pytest.fixture
def drive() -> Drive:
    """Return a drive at full pace."""
    drive = Drive()
    for step in range(1, 6):
        assert drive.step(100 * step, 0.015 * step) is not None
    return drive


def test_a_robot_on_its_setpoint_turns_its_wheels_as_that_moves(drive: Drive) -> None:
    order = drive.step(600, 0.09)
    assert order is not None
    assert (order.left_rad_s, order.right_rad_s) == pytest.approx((WHEEL_RAD_S, WHEEL_RAD_S))
    assert order.answers_ns == 600 * MS
    assert order.valid_s == pytest.approx(FRESH_S)
    assert drive.seat.fares() == ((0.15, 0.0), "driving", "")


def test_speed_is_built_up_from_rest_by_the_acceleration() -> None:
    drive = Drive()
    speeds = [order.left_rad_s * BODY.wheel_radius_m for step in range(4) if (order := drive.step(100 + 100 * step, 0.0)) is not None]
    assert speeds[0] <= 0.6 * 0.2 + 1e-9
    assert max(np.diff(speeds)) <= 0.06 + 1e-9


def test_each_broadcast_is_answered_once(drive: Drive) -> None:
    assert drive.seat.order() is None
    drive.hear(500, 0.075)
    assert drive.seat.order() is not None
    assert drive.seat.order() is None


def test_the_same_broadcast_again_gives_the_same_speeds_for_longer(drive: Drive) -> None:
    first = drive.step(600, 0.09)
    drive.now_s += 0.1
    drive.hear(600, 0.09)
    again = drive.seat.order()
    assert again == first


def test_new_wheel_readings_give_a_new_order_that_holds_no_longer_than_the_setpoint(drive: Drive) -> None:
    drive.now_s += 0.2
    drive.roll(520, 0.05)  # it has fallen behind
    order = drive.seat.order()
    assert order is not None
    assert order.left_rad_s > WHEEL_RAD_S
    assert order.valid_s == pytest.approx(FRESH_S - 0.2)
    assert order.answers_ns == 500 * MS


def test_orders_depend_on_the_stamp_and_not_on_how_often_it_was_decided(drive: Drive) -> None:
    other = Drive()
    for step in range(1, 6):
        other.step(100 * step, 0.015 * step)
    drive.roll(600, 0.08)
    drive.seat.order()  # with the old setpoint, before the new one comes
    assert drive.step(600, 0.08) == other.step(600, 0.08)


def test_setpoints_that_have_become_old_give_no_order_any_more(drive: Drive) -> None:
    drive.now_s += FRESH_S
    drive.roll(520, 0.078)
    assert drive.seat.order() is None
    drive.now_s += 0.55
    assert drive.seat.fares() == ((0.0, 0.0), "standing", "no setpoints for 1.0 s: standing")


def test_setpoints_wait_for_the_poses_of_their_stamp(drive: Drive) -> None:
    drive.roll(600, 0.09)
    drive.look(600)
    drive.hear(600, 0.09)
    assert drive.seat.order() is None
    drive.locate(600, Pose2(0.09, 0.0, 0.0))
    assert drive.seat.order() is not None


def test_setpoints_do_not_wait_for_ever(drive: Drive) -> None:
    drive.roll(600, 0.09)
    drive.hear(600, 0.09)
    drive.now_s += 1.01 * POSES_LIMIT_S
    assert drive.seat.order() is not None


def test_a_robot_that_is_not_in_the_broadcast_answers_and_stands(drive: Drive) -> None:
    drive.hear(500, 0.0, robot="r2")
    assert stands(drive.seat.order())
    assert drive.seat.fares() == ((0.0, 0.0), "standing", "no setpoint for this robot: standing")


def test_a_robot_without_pose_answers_and_stands() -> None:
    drive = Drive()
    drive.roll(100, 0.0)
    drive.look(100)
    drive.locate(100, Pose2.identity(), predicted=True)
    drive.hear(100, 0.0)
    assert stands(drive.seat.order())
    assert drive.seat.fares().reason == "no pose from the map server: standing"


def test_a_robot_without_the_servers_clock_answers_and_stands(drive: Drive) -> None:
    drive.now_ms = None
    drive.hear(500, 0.075)
    assert stands(drive.seat.order())


def test_the_pose_of_the_map_server_is_followed_and_not_the_robots_own(drive: Drive) -> None:
    drive.roll(600, 0.09)
    drive.look(600)
    drive.locate(600, Pose2(0.09, 0.05, 0.0))  # to the left of where it should be
    drive.hear(600, 0.09)
    order = drive.seat.order()
    assert order is not None
    assert order.left_rad_s > order.right_rad_s


def test_a_thing_in_the_way_slows_and_stops_the_robot(drive: Drive) -> None:
    drive.step(530, 0.08, (0.27, 0.0))
    drive.step(560, 0.084, (0.266, 0.0))
    slowed = drive.step(600, 0.09, (0.26, 0.0))  # 8.5 cm before the body
    assert slowed is not None
    assert 0.0 < slowed.left_rad_s < WHEEL_RAD_S
    assert drive.seat.fares().drive == "slowed"
    assert stands(drive.step(700, 0.155, (0.195, 0.0)))
    assert drive.seat.fares()[1:] == ("blocked", "something is in the way")


def held_up(drive: Drive, box_m: float) -> int:
    """Stand before a box that far ahead of the start, and drive up to it until the own body hides it; return the stamp [ms] of arrival."""
    for step in range(6, 16):
        x_m = 0.015 * max(step - 5, 6)
        drive.step(100 * step, x_m, (box_m - x_m, 0.0))
    for step in range(16, 21):
        drive.step(100 * step, 0.015 * (step - 5))
    return 2000


def test_a_robot_that_only_something_hidden_holds_up_steps_back_and_goes_on_when_nothing_is_there(drive: Drive) -> None:
    at_ms, x_m, least_m, ways = held_up(drive, box_m=0.41), 0.225, 0.225, []
    for stamp_ms in range(at_ms + 100, at_ms + 8000, 100):
        order = drive.step(stamp_ms, x_m, ahead_m=0.1)
        assert order is not None
        x_m += 0.1 * order.left_rad_s * BODY.wheel_radius_m
        least_m = min(least_m, x_m)
        ways.append(drive.seat.fares().reason)
    assert ways[0] == "something is in the way"
    assert ways.index("stepping back to see what is in the way") == pytest.approx(10 * HELD_S, abs=2)
    assert 0.225 - least_m == pytest.approx(BACK_M, abs=0.05)
    assert ways[-1] == ""
    assert x_m > 0.41


def test_it_steps_back_towards_nobody(drive: Drive) -> None:
    at_ms, place = held_up(drive, box_m=0.41), Pose2(0.225, 0.0, 0.0)
    for stamp_ms in range(at_ms + 100, at_ms + 5000, 100):
        drive.roll(stamp_ms, place.x_m)
        drive.look(stamp_ms)
        others = {"r1": place, "r2": Pose2(place.x_m - 0.2, 0.0, 0.0)}
        poses = (
            RobotPose(robot=name, arena_from_body=pose_tuple(pose), covariance=(0.0,) * 6, predicted=False) for name, pose in others.items()
        )
        drive.seat.locate(Poses(seq=0, stamp_ns=stamp_ms * MS, robots=tuple(poses)))
        drive.hear(stamp_ms, place.x_m + 0.1)
        assert stands(drive.seat.order())


def test_it_does_not_step_back_without_a_setpoint_and_begins_to_wait_anew_with_the_next(drive: Drive) -> None:
    at_ms = held_up(drive, box_m=0.41)
    for stamp_ms in range(at_ms + 100, at_ms + 2300, 100):
        drive.step(stamp_ms, 0.225, ahead_m=0.1)
    assert drive.seat.fares().reason == "stepping back to see what is in the way"
    for stamp_ms in range(at_ms + 2300, at_ms + 3000, 100):
        drive.roll(stamp_ms, 0.225)
        drive.look(stamp_ms)
        drive.locate(stamp_ms, Pose2(0.225, 0.0, 0.0))
        drive.hear(stamp_ms, 0.325, robot="r2")
        assert stands(drive.seat.order())
    assert stands(drive.step(at_ms + 3000, 0.225, ahead_m=0.1))
    assert drive.seat.fares().drive == "blocked"


@pytest.mark.parametrize("dropped", [False, True])
def test_without_usable_pictures_the_robot_stands_and_says_so(drive: Drive, dropped: bool) -> None:
    blind_ms = 500 + round(1e3 * BLIND_S)
    for stamp_ms in (blind_ms, blind_ms + 100):
        drive.roll(stamp_ms, 0.09)
        if dropped:
            drive.look(stamp_ms, dropped=True)
        drive.locate(stamp_ms, Pose2(0.09, 0.0, 0.0))
        drive.hear(stamp_ms, 0.09)
        assert stands(drive.seat.order()) == (stamp_ms > blind_ms)
    assert drive.seat.fares().reason == "no usable picture for 0.6 s: standing"


def test_without_wheel_readings_the_robot_stands_and_says_so(drive: Drive) -> None:
    drive.now_ms = 1100
    drive.look(1050)
    drive.locate(1100, Pose2(0.09, 0.0, 0.0))
    drive.hear(1100, 0.09)
    assert stands(drive.seat.order())
    assert drive.seat.fares().reason == "no wheel readings for 0.6 s: standing"


def test_all_orders_are_finite(drive: Drive) -> None:
    drive.locate(500, Pose2(1e-320, -1e-320, math.pi))
    drive.hear(500, 1.9)
    order = drive.seat.order()
    assert order is not None
    assert math.isfinite(order.left_rad_s + order.right_rad_s)
