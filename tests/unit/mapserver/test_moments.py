"""What is remembered of a robot without a place, and what a sighting is worth that only repeats another."""

from __future__ import annotations

import math

import pytest

from mapserver.mapping.joining.moments import MOST_GLANCES, Glance, moment_of, remembered
from mapserver.mapping.joining.pairings import SIGHT_M2, pairings_of
from protocol.geometry import Pose2
from protocol.messages import Identity, Sighting
from tests.unit.mapserver.worlds import STEP_NS, local_map, sighting_of

P_EYE, U_EYE = Pose2.identity(), Pose2(0.6, 0.0, math.pi)
STEP_M = 0.08


def glance(seq: int, way_m: float = 0.0, sightings: tuple[Sighting, ...] = (), epoch: int = 0) -> Glance:
    """Return a glance of a seeker that has driven some way, with r1 standing by and seeing somebody."""
    seen = sighting_of(P_EYE, U_EYE)
    seeker = local_map("r2", seq, odom=Pose2(way_m, 0.0, 0.0), sightings=sightings, epoch=epoch)
    return Glance(seeker, (local_map("r1", seq, sightings=[seen]),))


def pose_of_r1(robot: str, _: int) -> Pose2 | None:
    return P_EYE if robot == "r1" else None


def test_while_all_stand_the_glance_with_most_sightings_is_kept() -> None:
    seen = sighting_of(U_EYE, P_EYE)
    first, more, less = glance(0), glance(1, sightings=(seen,)), glance(2)
    assert remembered(remembered((first,), more), less) == (more,)


def test_who_has_moved_or_begun_anew_is_seen_afresh_and_the_oldest_is_forgotten() -> None:
    glances: tuple[Glance, ...] = ()
    for seq in range(MOST_GLANCES + 5):
        glances = remembered(glances, glance(seq, STEP_M * seq))
    assert [each.local_map.seq for each in glances] == list(range(5, MOST_GLANCES + 5))
    assert len(remembered(glances[-1:], glance(0, STEP_M * (MOST_GLANCES + 4), epoch=1))) == 2


def test_a_later_sighting_tells_as_much_as_what_it_shows_has_moved() -> None:
    def start_from_body(stamp_ns: int) -> Pose2:
        return Pose2(STEP_M * (stamp_ns // STEP_NS - 1), 0.0, 0.0)

    moments = [moment_of(glance(seq, STEP_M * seq), pose_of_r1, start_from_body) for seq in range(2)]
    pairings = pairings_of("r2", moments)
    assert pairings.chance_m2 == pytest.approx([SIGHT_M2, math.pi * STEP_M**2])


def test_a_sighting_that_names_somebody_shows_nobody_else() -> None:
    named = Glance(
        local_map("r2", 0, sightings=[sighting_of(U_EYE, P_EYE, Identity(kind="robot", name="r7"))]),
        (local_map("r1", 0, sightings=[sighting_of(P_EYE, U_EYE, Identity(kind="robot", name="r3"))]),),
    )
    moment = moment_of(named, pose_of_r1, lambda _: Pose2.identity())
    assert len(pairings_of("r2", [moment])) == 0
    assert len(pairings_of("r3", [moment])) == 1
