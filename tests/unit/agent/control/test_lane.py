"""The way that the reference has taken."""

from __future__ import annotations

import math

import numpy as np
import pytest

from agent.control.lane import LONGEST, NEAR_M, SPACING_M, Lane
from agent.control.limits import applied
from agent.control.tracking import Reference, track
from agent.control.twist import STANDING, Twist
from protocol.geometry import Array, Pose2
from tests.unit.agent.control.unicycle import LIMITS, PERIOD_S, Unicycle

PERIOD_NS = round(1e9 * PERIOD_S)
SPEED_M_S = 0.15


def round_the_corner(radius_m: float) -> list[Reference]:
    """Return references, a period apart, along a straight stretch, a right angle to the left, and another one, and then standing."""
    turn = Twist(SPEED_M_S, SPEED_M_S / radius_m)
    stages = [(Twist(SPEED_M_S, 0.0), 0.45), (turn, 0.5 * math.pi * radius_m), (Twist(SPEED_M_S, 0.0), 0.3)]
    references = [Reference(Pose2.identity(), Twist(SPEED_M_S, 0.0))]
    for twist, length_m in stages:
        for _ in range(round(length_m / SPEED_M_S / PERIOD_S)):
            references.append(Reference(references[-1].arena_from_body @ twist.motion(PERIOD_S), twist))
    return references + 60 * [Reference(references[-1].arena_from_body, STANDING)]


def driven(references: list[Reference], held: range, lane: Lane | None) -> Array:
    """Return the places, (n, 2), of a robot that follows references but in some steps, in which something holds it up."""
    robot, command, places = Unicycle(references[0].arena_from_body), STANDING, []
    for step, reference in enumerate(references):
        followed = reference
        if lane is not None:
            lane.note(step * PERIOD_NS, reference.arena_from_body)
            followed = lane.reference(reference, robot.pose)
        wanted = STANDING if step in held else track(robot.pose.between(followed.arena_from_body), followed.twist)
        command = applied(wanted, command, PERIOD_S, LIMITS)
        robot.drive(command)
        places.append(robot.pose[:2])
    return np.array(places)


def farthest_from_m(references: list[Reference], places_m: Array) -> float:
    """Return how far places, (n, 2), are at most from the way of the references, and what would be the rest of it."""
    on_m = [references[-1].arena_from_body.apply(np.array([0.01 * step, 0.0])) for step in range(5)]
    way_m = np.array([*(reference.arena_from_body[:2] for reference in references), *on_m])
    return float(np.hypot(*(places_m[:, None] - way_m).transpose(2, 0, 1)).min(axis=1).max())


@pytest.mark.parametrize("radius_m", [0.12, 0.2, 0.4])
def test_a_robot_that_was_held_up_before_a_bend_drives_the_bend_and_catches_up(radius_m: float) -> None:
    references, held = round_the_corner(radius_m), range(24, 36)
    places_m = driven(references, held, Lane())
    assert farthest_from_m(references, places_m) < 0.015
    assert farthest_from_m(references, driven(references, held, None)) > 0.04
    assert math.dist(places_m[-1], references[-1].arena_from_body[:2]) < 0.005


@pytest.mark.parametrize("radius_m", [0.12, 0.2, 0.4])
def test_a_robot_that_keeps_up_follows_the_reference_itself(radius_m: float) -> None:
    references, never = round_the_corner(radius_m), range(0)
    np.testing.assert_array_equal(driven(references, never, Lane()), driven(references, never, None))


def test_a_reference_that_stands_is_come_up_to_along_its_way() -> None:
    references = round_the_corner(0.12)
    places_m = driven(references, range(24, 70), Lane())  # by then it stands at the end
    assert farthest_from_m(references, places_m) < 0.02
    assert math.dist(places_m[-1], references[-1].arena_from_body[:2]) < 0.005


def at(*places_m: tuple[float, float], apart_s: float = PERIOD_S) -> Lane:
    lane = Lane()
    for step, (x_m, y_m) in enumerate(places_m):
        lane.note(round(1e9 * apart_s * step), Pose2(x_m, y_m, 0.0))
    return lane


def test_a_reference_that_leaps_begins_a_new_way() -> None:
    there, here = Reference(Pose2(0.5, 0.1, 0.0), STANDING), Pose2(0.3, 0.0, 0.0)
    assert at((0.3, 0.0), (0.5, 0.1)).reference(there, here) == there
    assert at((0.3, 0.0), (0.5, 0.1), apart_s=2.0).reference(there, here) != there


def test_of_a_way_that_crosses_itself_the_last_stretch_counts() -> None:
    way = [(0.02 * step, 0.0) for step in range(11)] + [(0.2, 0.02 * step) for step in range(1, 6)]
    way += [(0.2 - 0.02 * step, 0.1) for step in range(1, 6)] + [(0.1, 0.1 - 0.02 * step) for step in range(1, 11)]
    followed = at(*way).reference(Reference(Pose2(0.1, -0.1, -0.5 * math.pi), STANDING), Pose2(0.095, 0.0, 0.0))
    assert followed.arena_from_body.theta_rad == pytest.approx(-0.5 * math.pi)
    assert followed.arena_from_body[:2] == pytest.approx((0.1, 0.0), abs=SPACING_M)


def test_a_way_is_remembered_for_only_so_long() -> None:
    lane, last_m = at(*((0.02 * step, 0.0) for step in range(61))), 1.2
    followed = lane.reference(Reference(Pose2(last_m, 0.0, 0.0), STANDING), Pose2(0.1, 0.0, 0.0))
    assert followed.arena_from_body.x_m == pytest.approx(last_m - LONGEST * SPACING_M, abs=2 * SPACING_M)


def test_a_reference_close_by_or_one_that_goes_back_is_followed_itself() -> None:
    lane = at(*((0.02 * step, 0.0) for step in range(11)))
    for x_m, speed_m_s in ((0.2 - 0.9 * NEAR_M, 0.1), (0.0, -0.1)):
        reference = Reference(Pose2(0.2, 0.0, 0.0), Twist(speed_m_s, 0.0))
        assert lane.reference(reference, Pose2(x_m, 0.01, 0.0)) == reference
