"""A robot without a camera: where its speeds take it, and what it says of what it has seen on the way."""

from __future__ import annotations

import math

import numpy as np
import pytest

from agent.range_bearing.dead_reckoning import MAX_HOLD_S, DeadReckoning, MotionNoise, motion_covariance
from agent.range_bearing.method import RangeBearingMethod, SightingNoise
from protocol.fields import Packed, covariance_matrix
from protocol.geometry import Pose2
from protocol.messages import Identity, LocalMap, SensorReadings

MOTION = MotionNoise(forward_share=0.1, side_share=0.05, turn_share=0.1, walk_m_sqrt_s=0.01, walk_rad_sqrt_s=0.04)
SIGHT = SightingNoise(range_m=0.05, range_share=0.05, bearing_rad=0.01, target_m_s=0.05)
POST = Identity(kind="landmark", name="6")
OTHER = Identity(kind="robot", name="r2")
S = 1_000_000_000


def readings(
    until_ns: int, twists: dict[int, tuple[float, float]], seen: list[tuple[int, float, float, Identity]] | None = None
) -> SensorReadings:
    rows = seen or []
    return SensorReadings(
        until_ns=until_ns,
        twist_stamps_ns=Packed.of(np.array(list(twists), dtype=np.int64), "i8"),
        twists=Packed.of(np.array(list(twists.values()), dtype=np.float64).reshape(-1, 2), "f8"),
        sighting_stamps_ns=Packed.of(np.array([row[0] for row in rows], dtype=np.int64), "i8"),
        sightings=Packed.of(np.array([row[1:3] for row in rows], dtype=np.float64).reshape(-1, 2), "f8"),
        identities=tuple(row[3] for row in rows),
    )


def method(response_s: float = 0.0) -> RangeBearingMethod:
    return RangeBearingMethod("r1", 7, 0.17, response_s, MOTION, SIGHT)


def test_constant_speeds_drive_an_arc() -> None:
    reckoning = DeadReckoning(0.0)
    reckoning.add(0, 0.5, math.pi)
    assert reckoning.at(S).odom_from_body == pytest.approx(Pose2(0.0, 1.0 / math.pi, math.pi), abs=1e-9)


def test_a_base_that_responds_late_goes_on_at_its_old_speed_until_then() -> None:
    reckoning = DeadReckoning(0.25)
    for stamp_ns, speed_m_s in ((0, 0.4), (S // 2, 0.0)):
        reckoning.add(stamp_ns, speed_m_s, 0.0)
    assert [reckoning.at(stamp_ns).odom_from_body.x_m for stamp_ns in (S // 4, S // 2, S)] == pytest.approx([0.0, 0.1, 0.2])


def test_a_speed_that_is_not_said_again_ends() -> None:
    reckoning = DeadReckoning(0.0)
    reckoning.add(0, 0.1, 0.0)
    assert reckoning.at(100 * S).odom_from_body.x_m == pytest.approx(0.1 * MAX_HOLD_S)


def test_the_past_of_the_last_seconds_stays_known() -> None:
    reckoning = DeadReckoning(0.0)
    for second in range(30):
        reckoning.add(second * S, 0.1, 0.0)
    reckoning.forget_before(29 * S)
    assert reckoning.at(25 * S).odom_from_body.x_m == pytest.approx(2.5)


def test_uncertainty_grows_with_way_turn_and_time_and_least_sideways() -> None:
    reckoning = DeadReckoning(0.0)
    reckoning.add(0, 0.2, 0.0)
    straight = motion_covariance(reckoning.at(0), reckoning.at(S), MOTION)
    turning = DeadReckoning(0.0)
    turning.add(0, 0.2, 1.0)
    turned = motion_covariance(turning.at(0), turning.at(S), MOTION)
    assert straight[1, 1] < straight[0, 0]
    assert turned[2, 2] > straight[2, 2] > 0.0
    assert np.diag(motion_covariance(reckoning.at(0), reckoning.at(0), MOTION)) == pytest.approx(2.5e-7)


def test_local_maps_chain_to_the_odometry() -> None:
    robot = method()
    maps = [robot.step(readings(number * S, {number * S - S // 2: (0.1, 0.2)})) for number in range(1, 5)]
    assert [each.seq for each in maps] == [0, 1, 2, 3]
    chained = Pose2(*maps[0].odom_from_body)
    for each in maps[1:]:
        chained = chained @ Pose2(*each.previous_from_body)
    assert chained == pytest.approx(maps[-1].odom_from_body)


def test_what_was_seen_on_the_way_is_told_from_where_the_robot_stands_now() -> None:
    local_map = method().step(readings(S, {0: (0.2, 0.0)}, [(S // 2, 2.0, 0.0, POST), (S // 2, 2.0, math.pi / 2, POST)]))
    ahead, beside = local_map.sightings
    assert (ahead.range_m, ahead.bearing_rad) == pytest.approx((1.9, 0.0), abs=1e-9)
    assert (beside.range_m, beside.bearing_rad) == pytest.approx((math.hypot(2.0, 0.1), math.atan2(2.0, -0.1)))
    assert ahead.identity == POST


def test_a_carried_sighting_is_worth_less_and_that_of_a_robot_least() -> None:
    def covariances(seen_ns: int, who: Identity) -> tuple[float, float]:
        [seen] = method().step(readings(S, {0: (0.2, 0.5)}, [(seen_ns, 2.0, 0.3, who)])).sightings
        return seen.covariance[0], seen.covariance[2]

    fresh, old, moving = covariances(S, POST), covariances(S // 2, POST), covariances(S // 2, OTHER)
    assert fresh == pytest.approx((0.05**2 + 0.1**2, 0.01**2), rel=0.01)
    assert fresh[1] < old[1] < moving[1]
    assert fresh[0] < moving[0]


def test_a_standing_robot_says_the_same_of_what_it_saw_before() -> None:
    local_map: LocalMap = method().step(readings(S, {0: (0.0, 0.0)}, [(S // 4, 3.0, -0.4, POST)]))
    [seen] = local_map.sightings
    assert (seen.range_m, seen.bearing_rad) == pytest.approx((3.0, -0.4))
    assert (np.linalg.eigvalsh(covariance_matrix(local_map.motion_covariance)) > 0.0).all()
