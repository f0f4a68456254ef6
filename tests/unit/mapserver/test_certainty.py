"""When a robot without a place is certain of it: what else it could be, and who else could stand there."""

from __future__ import annotations

import numpy as np
import pytest

from mapserver.mapping.joining.certainty import Claim, certain, margins_nats
from mapserver.mapping.joining.hypotheses import Hypothesis
from protocol.geometry import Pose2

HERE, THERE, YONDER = Pose2(0.0, 0.0, 0.0), Pose2(1.0, 0.0, 0.0), Pose2(2.0, 0.0, 0.0)
TURNED = Pose2(0.0, 0.0, 1.0)


def claim(*places: tuple[Pose2, float], sigma: float = 0.01, seen: int = 5) -> Claim:
    """Return a claim, the likeliest place first."""
    return Claim(Pose2.identity(), [Hypothesis(pose, evidence, np.eye(3) * sigma**2, seen) for pose, evidence in places])


def test_a_place_without_a_rival_is_certain_when_chance_does_not_explain_it() -> None:
    assert certain({"r2": claim((HERE, 15.0))}) == "r2"
    assert certain({"r2": claim((HERE, 13.0))}) is None


def test_another_place_or_heading_that_is_nearly_as_likely_leaves_it_open() -> None:
    assert certain({"r2": claim((HERE, 40.0), (THERE, 30.0))}) is None
    assert certain({"r2": claim((HERE, 40.0), (TURNED, 30.0))}) is None
    assert certain({"r2": claim((HERE, 40.0), (THERE, 20.0), (TURNED, 20.0))}) == "r2"


def test_a_pose_that_is_not_well_told_is_not_certain_however_likely() -> None:
    assert certain({"r2": claim((HERE, 40.0), sigma=0.1)}) is None


def test_a_place_that_another_could_have_taken_as_well_is_nobodys() -> None:
    assert certain({"r2": claim((HERE, 40.0)), "r3": claim((HERE, 35.0))}) is None


def test_a_rival_that_has_a_better_place_is_none() -> None:
    margins = margins_nats({"r2": claim((HERE, 40.0)), "r3": claim((THERE, 60.0), (HERE, 35.0))})
    assert margins["r2"] == pytest.approx(25.0)
    assert margins["r3"] == pytest.approx(25.0)


def test_a_place_where_a_rival_could_be_that_is_sure_of_no_other_is_nobodys() -> None:
    assert certain({"r2": claim((HERE, 40.0)), "r3": claim((HERE, 2.0))}) is None
    assert certain({"r2": claim((HERE, 40.0)), "r3": claim((THERE, 20.0), (HERE, 2.0))}) == "r2"
    assert certain({"r2": claim((HERE, 40.0)), "r3": claim((HERE, 2.0), seen=3)}) == "r2"


def test_whoever_could_all_move_up_by_one_place_are_not_told_apart() -> None:
    claims = {
        "r2": claim((HERE, 40.0), (THERE, 38.0)),
        "r3": claim((THERE, 40.0), (YONDER, 38.0)),
        "r4": claim((YONDER, 40.0), (HERE, 38.0)),
    }
    assert certain(claims) is None


def test_nobody_who_saw_nothing_is_certain() -> None:
    assert certain({}) is None
    assert margins_nats({"r2": claim()}) == {"r2": 0.0}
