"""A robot that is lifted while driving, and put down elsewhere: it is noticed, adds nothing to the map, and finds its place anew."""

from __future__ import annotations

import math

import pytest

from mapserver.mapping.poses.association import Match
from mapserver.mapping.poses.lifting import LEAST_LOOKS, LIFTED_NS, LiftWatch, Look
from mapserver.pipeline import Merged
from protocol.geometry import Pose2
from protocol.messages import Sighting
from tests.unit.mapserver.seekers import Team
from tests.unit.mapserver.worlds import NOBODY, SIGHTING_VARIANCE, STEP_NS, local_map

STARTS = {"r1": Pose2(0.0, 0.0, 0.0), "r2": Pose2(-0.5, 0.4, 0.3), "r3": Pose2(-0.5, -0.4, -0.2)}
ELSEWHERE = Pose2(0.5, 0.6, 2.0)
ARCS = {"r1": Pose2(0.03, 0.0, 0.02), "r2": Pose2(0.03, 0.0, -0.06), "r3": Pose2(0.03, 0.0, 0.05)}
MOST_STEPS = 40


def drive_until(team: Team, is_so: bool, robot: str) -> tuple[Merged, int]:
    """Drive until a robot is, or is not, a seeker; return the last step and how many there were."""
    for number in range(1, MOST_STEPS + 1):
        merged = team.step(ARCS)
        if (robot in merged.poses.seekers) == is_so:
            return merged, number
    pytest.fail(f"{robot} is {'no' if is_so else 'still a'} seeker after {MOST_STEPS} steps")


@pytest.fixture
def team() -> Team:
    """Return a team of which everybody has found its place and has driven since."""
    team = Team(STARTS)
    for robot in ("r2", "r3"):
        drive_until(team, False, robot)
    team.drive(5, ARCS)
    return team


def test_nobody_is_lost_who_drives_as_it_says(team: Team) -> None:
    assert team.drive(20, ARCS).poses.seekers == ()


def test_a_robot_that_was_put_down_elsewhere_is_noticed_and_finds_its_place_anew(team: Team) -> None:
    team.poses["r2"] = ELSEWHERE
    merged, steps = drive_until(team, True, "r2")
    assert steps * STEP_NS <= 2 * LIFTED_NS
    assert merged.poses.seekers == ("r2",)
    assert [each.robot for each in merged.poses.robots] == ["r1", "r3"]
    merged, _ = drive_until(team, False, "r2")
    assert team.error_m(merged, "r2") < 0.05
    merged = team.drive(10, ARCS)
    assert merged.poses.seekers == ()
    assert all(team.error_m(merged, robot) < 0.03 for robot in STARTS)


def test_its_smoothed_path_holds_both_pieces_in_order(team: Team) -> None:
    team.poses["r2"] = ELSEWHERE
    drive_until(team, True, "r2")
    drive_until(team, False, "r2")
    [path] = [each for each in team.pipeline.trajectories().robots if each.robot == "r2"]
    stamps_ns = path.stamps_ns.array()
    assert (stamps_ns[1:] > stamps_ns[:-1]).all()


def seen_at(range_m: float) -> Sighting:
    return Sighting(range_m=range_m, bearing_rad=0.1, covariance=SIGHTING_VARIANCE, identity=NOBODY)


def looks(stranger_m: float, own_m: float, seq: int) -> list[Look]:
    """Return how r1 and r3 see each other, r1 a stranger besides, and r2 somebody whom it does not expect."""
    other, stranger = seen_at(0.8), seen_at(stranger_m)
    return [
        Look(local_map("r1", seq, sightings=[other, stranger]), [Match(other, "r3")]),
        Look(local_map("r2", seq, sightings=[seen_at(own_m)]), []),
        Look(local_map("r3", seq), []),
    ]


def lifted_after(steps: int, stranger_m: float, own_m: float) -> bool:
    watch = LiftWatch()
    for seq in range(steps):
        watch.note(seq * STEP_NS, looks(stranger_m, own_m, seq))
    return watch.take_lifted("r2")


LONG = math.ceil(LIFTED_NS / STEP_NS) + LEAST_LOOKS


def test_two_that_see_strangers_equally_far_away_see_each_other() -> None:
    assert lifted_after(LONG, 1.10, 1.11)


def test_two_that_see_strangers_at_different_ranges_do_not() -> None:
    assert not lifted_after(LONG, 1.10, 1.20)


def test_a_passing_contradiction_casts_doubt_only() -> None:
    watch = LiftWatch()
    watch.note(STEP_NS, looks(1.1, 1.1, 0))
    assert watch.is_doubted("r2")
    assert not watch.take_lifted("r2")


def test_a_sighting_as_believed_ends_all_doubt() -> None:
    watch = LiftWatch()
    watch.note(STEP_NS, looks(1.1, 1.1, 0))
    sighting = seen_at(0.5)
    watch.note(2 * STEP_NS, [Look(local_map("r3", 1, sightings=[sighting]), [Match(sighting, "r2")])])
    assert not watch.is_doubted("r2")


def test_a_contradiction_that_does_not_come_again_is_forgotten() -> None:
    watch = LiftWatch()
    watch.note(STEP_NS, looks(1.1, 1.1, 0))
    watch.note(STEP_NS + LIFTED_NS, [Look(local_map("r2", 1), [])])
    assert not watch.is_doubted("r2")
