"""Which setpoints are followed."""

from __future__ import annotations

import pytest

from agent.control.limits import DriveLimits
from agent.control.setpoints import (
    DUPLICATE,
    EXPIRED,
    FARTHEST_M,
    FRESH_S,
    NO_CLOCK,
    NO_SETPOINT,
    OLD_EPOCH,
    OUT_OF_ORDER,
    TOO_FAR,
    TOO_FAST,
    SetpointGate,
    Standing,
)
from agent.control.tracking import Reference
from agent.control.twist import Twist
from protocol.geometry import Pose2
from protocol.messages import Setpoints
from tests.unit.agent.control.broadcasts import MS, VALID_MS, broadcast

HERE = Pose2.identity()
NOW_S = 50.0


def gate(*messages: Setpoints) -> SetpointGate:
    """Return a gate that was offered some broadcasts."""
    gate = SetpointGate("r1", DriveLimits())
    for message in messages:
        gate.offer(message, NOW_S)
    return gate


def test_the_newest_setpoint_is_followed() -> None:
    heard = gate(broadcast(100, 0), broadcast(200, 1, pose=(0.1, 0.2, 0.3), turn_rad_s=0.4))
    assert heard.reference(200 * MS, HERE) == Reference(Pose2(0.1, 0.2, 0.3), Twist(0.15, 0.4))
    assert not heard.counts


def test_without_broadcast_and_without_place_in_it_the_robot_stands() -> None:
    assert gate().reference(100 * MS, HERE) == Standing(NO_SETPOINT)
    assert gate(broadcast(100, 0, robot="r2")).reference(100 * MS, HERE) == Standing(NO_SETPOINT)


@pytest.mark.parametrize(
    ("message", "reason"),
    [
        (broadcast(200, 5), DUPLICATE),
        (broadcast(300, 4), OUT_OF_ORDER),
        (broadcast(100, 6), OUT_OF_ORDER),
        (broadcast(300, 6, epoch=1), OLD_EPOCH),
    ],
)
def test_a_broadcast_out_of_order_is_refused_and_the_last_one_holds(message: Setpoints, reason: str) -> None:
    last = broadcast(200, 5, epoch=2) if reason == OLD_EPOCH else broadcast(200, 5)
    heard = gate(last, message)
    assert heard.counts == {reason: 1}
    assert heard.newest is not None
    assert heard.newest.message == last


def test_a_restarted_map_server_begins_anew() -> None:
    heard = gate(broadcast(900, 70, epoch=1), broadcast(800, 0, epoch=2))
    assert heard.newest is not None
    assert heard.newest.stamp_ns == 800 * MS
    assert not heard.counts


def test_the_same_stamp_again_is_taken_as_long_as_the_number_grows() -> None:
    heard = gate(broadcast(200, 5))
    heard.offer(broadcast(200, 6), NOW_S + 0.1)
    assert heard.newest is not None
    assert heard.newest.left_s(NOW_S + 0.1) == pytest.approx(FRESH_S)


def test_a_broadcast_counts_for_less_than_half_a_second_after_it_came() -> None:
    newest = gate(broadcast(200, 5)).newest
    assert newest is not None
    assert newest.left_s(NOW_S + 0.2) == pytest.approx(FRESH_S - 0.2)
    assert newest.left_s(NOW_S + 0.5) < 0.0


@pytest.mark.parametrize(
    ("message", "now_ms", "reason"),
    [
        (broadcast(100, 0), 100 + VALID_MS + 1, EXPIRED),
        (broadcast(100, 0, speed_m_s=0.26), 100, TOO_FAST),
        (broadcast(100, 0, turn_rad_s=-2.6), 100, TOO_FAST),
        (broadcast(100, 0, pose=(FARTHEST_M + 0.01, 0.0, 0.0)), 100, TOO_FAR),
    ],
)
def test_a_setpoint_that_cannot_be_followed_is_refused_and_counted_once(message: Setpoints, now_ms: int, reason: str) -> None:
    heard = gate(message)
    for _ in range(3):
        assert heard.reference(now_ms * MS, HERE) == Standing(reason)
    assert heard.counts == {reason: 1}


def test_without_the_servers_clock_no_setpoint_is_valid() -> None:
    assert gate(broadcast(100, 0)).reference(None, HERE) == Standing(NO_CLOCK)


def test_a_setpoint_is_valid_to_its_last_moment() -> None:
    assert isinstance(gate(broadcast(100, 0)).reference((100 + VALID_MS) * MS, HERE), Reference)
