"""The world that moves, step by step, without any bus."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sim.world.drive import Wheels
from sim.world.world import Moment, World
from tests.unit.sim.world.stages import EXACT, PERIOD_NS, world

START_NS = 1_700_000_000_000_000_000
SPEED_RAD_S = 5.0  # 0.15 m/s


def drive(turning: World, robot: str, left_rad_s: float = SPEED_RAD_S, right_rad_s: float = SPEED_RAD_S) -> None:
    turning.command(robot, Wheels(left_rad_s, right_rad_s), turning.now_ns)


def steps(turning: World, count: int) -> list[Moment]:
    return [turning.step() for _ in range(count)]


def x_m(moment: Moment, robot: int = 0) -> float:
    return moment.robots[robot].arena_from_body.x_m


def test_a_robot_that_is_told_nothing_stands() -> None:
    last = steps(world((0.0, 0.0, 0.3)), 20)[-1]
    assert last.robots[0].arena_from_body == (0.0, 0.0, 0.3)


def test_a_command_holds_for_ever() -> None:
    turning = world((-1.5, 0.0, 0.0))
    drive(turning, "r1")
    assert x_m(steps(turning, 100)[-1]) == pytest.approx(-1.5 + 0.15 * 10.0)


def test_a_command_takes_effect_after_its_delay() -> None:
    turning = world((0.0, 0.0, 0.0), truth={**EXACT, "command_delay_s": 0.05})
    drive(turning, "r1")
    assert x_m(turning.step()) == pytest.approx(0.15 * 0.05)


def test_a_command_that_comes_between_two_moments_counts_from_there() -> None:
    turning = world((0.0, 0.0, 0.0))
    turning.command("r1", Wheels(SPEED_RAD_S, SPEED_RAD_S), turning.now_ns + 60_000_000)
    assert x_m(turning.step()) == pytest.approx(0.15 * 0.04)


def test_wheels_that_are_larger_than_drawn_go_farther() -> None:
    turning = world((0.0, 0.0, 0.0), truth={**EXACT, "left_wheel_scale": 1.02, "right_wheel_scale": 1.02})
    drive(turning, "r1")
    assert x_m(steps(turning, 10)[-1]) == pytest.approx(0.15 * 1.02)


def test_a_wheel_that_loses_its_grip_for_a_while_turns_the_robot() -> None:
    fault = {"robot": "r1", "kind": "wheel_slips", "from_s": 0.2, "until_s": 0.4, "wheel": "left", "grip": 0.5}
    turning = world((-1.0, 0.0, 0.0), faults=[fault])
    drive(turning, "r1")
    moments = steps(turning, 10)
    assert moments[1].robots[0].arena_from_body.theta_rad == 0.0
    assert moments[-1].robots[0].arena_from_body.theta_rad == pytest.approx(0.5 * 0.15 * 0.2 / 0.12)
    assert moments[-1].encoders["r1"].angles_rad[-1] == pytest.approx((5.0, 5.0), abs=0.007)


LIFT = {"robot": "r1", "kind": "lifted", "from_s": 0.2, "until_s": 0.6, "to": (0.5, 0.7, 1.5)}


def test_a_robot_that_is_lifted_is_carried_to_where_it_is_put_down_whatever_its_wheels_do() -> None:
    turning = world((-1.0, 0.0, 0.0), faults=[LIFT])
    drive(turning, "r1")
    moments = steps(turning, 10)
    heights_m = [moment.robots[0].height_m for moment in moments]
    assert [height_m > 0.0 for height_m in heights_m] == [False] * 2 + [True] * 4 + [False] * 4
    assert moments[5].robots[0].arena_from_body == pytest.approx((0.5, 0.7, 1.5))
    assert moments[-1].robots[0].arena_from_body == pytest.approx((0.5 + 0.06 * np.cos(1.5), 0.7 + 0.06 * np.sin(1.5), 1.5))
    assert moments[-1].encoders["r1"].angles_rad[-1] == pytest.approx((5.0, 5.0), abs=0.007)


def test_a_robot_that_is_carried_runs_into_nobody() -> None:
    turning = world(
        (-1.0, 0.0, 0.0), (-0.7, 0.0, 0.0), faults=[{**LIFT, "robot": "r2", "from_s": 0.0, "until_s": 5.0, "to": (-0.2, 0.0, 0.0)}]
    )
    drive(turning, "r1")
    assert not any(moment.collisions for moment in steps(turning, 20))


def test_encoders_are_read_at_50_hz_and_at_the_very_start() -> None:
    turning = world((0.0, 0.0, 0.0))
    drive(turning, "r1")
    encoders = turning.step().encoders["r1"]
    assert (encoders.stamps_ns - START_NS).tolist() == [20_000_000 * number for number in range(1, 6)]
    assert encoders.angles_rad[:, 0] == pytest.approx(SPEED_RAD_S * 0.02 * np.arange(1, 6), abs=0.007)


def test_the_first_moment_is_the_start() -> None:
    turning = world((0.0, 0.0, 0.0))
    assert (turning.now_ns, turning.next_ns) == (START_NS, START_NS + PERIOD_NS)


def test_a_camera_rate_that_fits_no_substep_is_kept_exactly() -> None:
    turning = world((-1.0, 0.0, 0.0), camera={"rate_hz": 30.0})
    drive(turning, "r1")
    moments = steps(turning, 30)
    assert moments[-1].stamp_ns == START_NS + 30 * 33_333_333
    assert x_m(moments[-1]) == pytest.approx(-1.0 + 0.15, abs=1e-6)
    assert sum(len(moment.encoders["r1"].stamps_ns) for moment in moments) == 49  # the fiftieth is due 10 ns later


def test_a_body_stops_at_a_box_and_the_collision_counts_once() -> None:
    turning = world((0.0, 0.0, 0.0), boxes=[{"centre_m": (0.5, 0.0), "size_m": (0.2, 0.2), "height_m": 0.1}])
    drive(turning, "r1")
    moments = steps(turning, 50)
    assert x_m(moments[-1]) == pytest.approx(0.4 - 0.075, abs=0.002)
    assert x_m(moments[-1]) < 0.4 - 0.075
    [hit] = [collision for moment in moments for collision in moment.collisions]
    assert (hit.robot, hit.other) == ("r1", "box-0")
    assert moments[-1].collision_counts == {"r1": 1}


def test_a_stopped_body_can_turn_and_drive_away() -> None:
    turning = world((0.2, 0.0, 0.0), boxes=[{"centre_m": (0.5, 0.0), "size_m": (0.2, 0.2), "height_m": 0.1}])
    drive(turning, "r1")
    steps(turning, 15)
    drive(turning, "r1", -SPEED_RAD_S, -SPEED_RAD_S)
    assert x_m(steps(turning, 10)[-1]) < 0.2


def test_wheels_of_a_stopped_body_go_on_turning() -> None:
    turning = world((0.32, 0.0, 0.0), boxes=[{"centre_m": (0.5, 0.0), "size_m": (0.2, 0.2), "height_m": 0.1}])
    drive(turning, "r1")
    assert steps(turning, 20)[-1].encoders["r1"].angles_rad[-1] == pytest.approx((10.0, 10.0), abs=0.007)


@pytest.mark.parametrize(("theta_rad", "wall"), [(0.0, "east"), (math.pi / 2, "north"), (math.pi, "west"), (-math.pi / 2, "south")])
def test_every_wall_holds(theta_rad: float, wall: str) -> None:
    turning = world((0.0, 0.0, theta_rad))
    drive(turning, "r1", 15.0, 15.0)
    moments = steps(turning, 60)
    pose = moments[-1].robots[0].arena_from_body
    assert max(abs(pose.x_m) - 2.0, abs(pose.y_m) - 1.5) == pytest.approx(-0.075, abs=0.004)
    assert [collision.other for moment in moments for collision in moment.collisions] == [f"wall-{wall}"]


def test_a_robot_that_runs_into_a_standing_one_is_the_one_that_collides() -> None:
    turning = world((0.0, 0.0, 0.0), (0.5, 0.0, 0.0))
    drive(turning, "r1")
    last = steps(turning, 50)[-1]
    assert last.collision_counts == {"r1": 1, "r2": 0}
    assert x_m(last, 1) == 0.5
    assert x_m(last) == pytest.approx(0.35, abs=0.002)


def test_a_person_who_walks_into_a_robot_neither_moves_it_nor_counts() -> None:
    person = {"way_m": ((0.5, 1.4), (0.5, -1.4)), "speed_m_s": 0.7}
    turning = world((0.0, 0.0, 0.0), (0.5, 0.0, 0.0), people=[person])
    drive(turning, "r2", 15.0, -15.0)  # on the spot
    last = steps(turning, 45)[-1]
    assert last.robots[1].arena_from_body[:2] == (0.5, 0.0)
    assert last.collision_counts == {"r1": 0, "r2": 0}
    assert last.people == ()


def test_a_robot_stops_at_a_leg() -> None:
    person = {"name": "ann", "way_m": ((0.5, 0.1), (0.5, -1.4)), "speed_m_s": 0.01}
    turning = world((0.0, 0.0, 0.0), people=[person])
    drive(turning, "r1")
    moments = steps(turning, 50)
    assert 0.3 < x_m(moments[-1]) < 0.5 - 0.05 - 0.075
    assert {collision.other for moment in moments for collision in moment.collisions} <= {"ann-left", "ann-right"}
    assert moments[-1].collision_counts["r1"] >= 1


def test_the_same_scenario_turns_the_same_way_every_time() -> None:
    def last() -> Moment:
        turning = world((-1.0, 0.0, 0.0), (-1.0, 0.5, 0.0), truth={}, seed=4)
        drive(turning, "r1")
        drive(turning, "r2")
        return steps(turning, 50)[-1]

    one, other = last(), last()
    assert [placed.arena_from_body for placed in one.robots] == [placed.arena_from_body for placed in other.robots]
    assert one.robots[0].arena_from_body.y_m != 0.0  # slip is there
    assert one.robots[1].arena_from_body.y_m - 0.5 != one.robots[0].arena_from_body.y_m  # and each robot has its own
