"""Whether a robot without a place is certain of it by now, given what speaks for its places and for those of all others without one.

Robots cannot be told apart: where another one might as well be the one that was seen, nobody is certain.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from scipy.optimize import linear_sum_assignment

from mapserver.mapping.joining.hypotheses import Hypothesis
from protocol.geometry import Array, Pose2

CERTAIN_NATS = 14.0  # a million to one
SAME_M, SAME_RAD = 0.15, 0.15  # two poses that are nearer to each other are one
MISFITS = 1  # moments at which who moves alike may yet have been out of step
SURE_SIGMA = np.array([0.05, 0.05, 0.05])  # of a pose that is told well enough [m, m, rad; body]


class Claim(NamedTuple):
    """What speaks for a seeker's places, the likeliest first."""

    start_from_body: Pose2  # now
    hypotheses: Sequence[Hypothesis]

    def places(self) -> list[Pose2]:
        """Return arena_from_body of all hypotheses."""
        return [each.arena_from_start @ self.start_from_body for each in self.hypotheses]

    def items(self) -> Iterator[tuple[Hypothesis, Pose2]]:
        """Yield all hypotheses, each with its arena_from_body."""
        return zip(self.hypotheses, self.places(), strict=True)

    def without(self, taken: Sequence[Pose2]) -> Claim:
        """Return what is left where nobody can stand at the places that are taken."""
        free = [each for each, place in self.items() if not any(is_same_place(place, other) for other in taken)]
        return self._replace(hypotheses=free)


def certain(claims: Mapping[str, Claim]) -> str | None:
    """Return the seeker whose first hypothesis is certain, the most certain of several; None where none is."""
    margins = margins_nats(claims)
    best = max(margins, key=lambda robot: margins[robot], default=None)
    return best if best is not None and margins[best] >= CERTAIN_NATS else None


def margins_nats(claims: Mapping[str, Claim]) -> dict[str, float]:
    """Return by how much the first hypothesis of each seeker beats all else: chance, another pose, and all seekers assigned otherwise.

    No two stand in one place, so the evidence for all together is that of the best assignment of seekers to places. And whoever moves
    as what was seen there must be as certain to be elsewhere: in an even formation others see their neighbours as it would see its own.
    """
    told = {robot: claim for robot, claim in claims.items() if claim.hypotheses}
    places = _distinct([place for claim in told.values() for place in claim.places()])
    values = np.array([[_value(claim, place) for place in places] for claim in told.values()]).reshape(len(told), len(places))
    best = _assigned(values)
    margins = dict.fromkeys(claims, 0.0)
    for row, (robot, claim) in enumerate(told.items()):
        otherwise = values.copy()
        otherwise[row, [is_same_place(place, claim.places()[0]) for place in places]] = 0.0
        rivals = [_margin_elsewhere(rival, claim) for other, rival in told.items() if other != robot]
        margins[robot] = min([best - _assigned(otherwise), _margin_of_pose(claim), *rivals])
    return margins


def is_same_place(first: Pose2, second: Pose2) -> bool:
    """Tell whether two robots could not stand at both."""
    return float(np.hypot(first.x_m - second.x_m, first.y_m - second.y_m)) < SAME_M


def _distinct(places: Sequence[Pose2]) -> list[Pose2]:
    kept: list[Pose2] = []
    for place in places:
        if not any(is_same_place(place, other) for other in kept):
            kept.append(place)
    return kept


def _value(claim: Claim, place: Pose2) -> float:
    """Return the evidence that a seeker stands in a place, 0 where it is less than chance."""
    return max([0.0, *(each.evidence for each, at in claim.items() if is_same_place(at, place))])


def _assigned(values: Array) -> float:
    """Return the greatest sum of values, (seekers, places), with one place a seeker and one seeker a place; who has none adds nothing."""
    return float(values[linear_sum_assignment(values, maximize=True)].sum())


def _margin_of_pose(claim: Claim) -> float:
    """Return by how much the first hypothesis beats every other pose, and chance; 0 where its pose is not well told."""
    if not (np.diag(claim.hypotheses[0].covariance) <= SURE_SIGMA**2).all():
        return 0.0
    pose = claim.places()[0]
    others = [each.evidence for each, at in claim.items() if not _is_same_pose(at, pose)]
    return claim.hypotheses[0].evidence - max([0.0, *others])


def _margin_elsewhere(rival: Claim, claim: Claim) -> float:
    """Return by how much a rival's evidence for other places beats that for the place of a claim; boundless where it moves otherwise."""
    place, seen = claim.places()[0], claim.hypotheses[0].seen
    there = [each.evidence for each, at in rival.items() if is_same_place(at, place) and each.seen >= seen - MISFITS]
    elsewhere = [each.evidence for each, at in rival.items() if not is_same_place(at, place)]
    return max([0.0, *elsewhere]) - max(there) if there else math.inf


def _is_same_pose(first: Pose2, second: Pose2) -> bool:
    return is_same_place(first, second) and abs(first.between(second).theta_rad) < SAME_RAD
