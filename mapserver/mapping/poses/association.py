"""Which anonymous sighting is which robot: gated against where every robot is believed to be, nearest first."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from mapserver.mapping.belief import Belief
from mapserver.mapping.covariance import made_definite
from protocol.geometry import Array
from protocol.messages import Sighting

ASSOCIATION_SIGMA_M = 0.03  # what the covariances do not know: shadows at the base, unequal stamps; alone it makes a gate of 0.11 m
GATE_CHI_SQUARED = 13.8  # 99.9 % of 2 degrees of freedom
LEAST_SIGHTING_VARIANCE = np.array([1e-8, 1e-8])  # of range [m^2] and bearing [rad^2]: nobody measures below 0.1 mm and 0.1 mrad
MAX_GATE_M = 0.4  # beyond this a match is worth less than none, however uncertain the poses are


class Match(NamedTuple):
    """A sighting and the robot that it shows."""

    sighting: Sighting
    robot: str


class _Candidate(NamedTuple):
    distance_squared: float
    number: int
    robot: str


def sighting_covariance(sighting: Sighting) -> Array:
    """Return the message's covariance of (range, bearing), shape (2, 2) [m^2, m rad, rad^2], made safe to invert."""
    range_range, range_bearing, bearing_bearing = sighting.covariance
    stated = np.array([[range_range, range_bearing], [range_bearing, bearing_bearing]])
    return made_definite(stated, LEAST_SIGHTING_VARIANCE)


def sighted_point(sighting: Sighting) -> Array:
    """Return the sighted base centre, shape (2,) [m; body]."""
    return sighting.range_m * np.array([math.cos(sighting.bearing_rad), math.sin(sighting.bearing_rad)])


def associate(sightings: Sequence[Sighting], observer: Belief, others: Mapping[str, Belief]) -> list[Match]:
    """Match sightings of one picture to robots.

    A sighting that names a known robot is taken at its word; an anonymous one shows the robot whose predicted place is
    nearest in the Mahalanobis sense, within the gate. Each robot and each sighting is matched at most once.
    """
    named = [Match(s, s.identity.name) for s in sightings if s.identity.kind == "robot" and s.identity.name in others]
    taken = {match.robot for match in named}
    anonymous = [s for s in sightings if s.identity.kind == "none"]
    free = {robot: belief for robot, belief in others.items() if robot not in taken}
    return named + _nearest_first(anonymous, observer, free)


def _nearest_first(sightings: Sequence[Sighting], observer: Belief, robots: Mapping[str, Belief]) -> list[Match]:
    candidates = [
        _Candidate(distance, number, robot)
        for number, sighting in enumerate(sightings)
        for robot, belief in robots.items()
        if (distance := _gated_distance_squared(sighting, observer, belief)) is not None
    ]
    matches: dict[int, str] = {}
    for candidate in sorted(candidates):
        if candidate.number not in matches and candidate.robot not in matches.values():
            matches[candidate.number] = candidate.robot
    return [Match(sightings[number], robot) for number, robot in sorted(matches.items())]


def _gated_distance_squared(sighting: Sighting, observer: Belief, robot: Belief) -> float | None:
    point_body = sighted_point(sighting)
    offset = observer.arena_from_body.apply(point_body) - np.array(robot.arena_from_body[:2])
    if float(np.hypot(*offset)) > MAX_GATE_M:
        return None
    covariance = (
        observer.covariance_of_point(point_body)
        + robot.position_covariance()
        + _sighting_covariance_in_arena(sighting, observer)
        + ASSOCIATION_SIGMA_M**2 * np.eye(2)
    )
    distance_squared = float(offset @ np.linalg.solve(covariance, offset))
    return distance_squared if distance_squared <= GATE_CHI_SQUARED else None


def _sighting_covariance_in_arena(sighting: Sighting, observer: Belief) -> Array:
    cos, sin = math.cos(sighting.bearing_rad), math.sin(sighting.bearing_rad)
    polar_to_body = np.array([[cos, -sighting.range_m * sin], [sin, sighting.range_m * cos]])
    jacobian = observer.arena_from_body.rotation() @ polar_to_body
    return np.asarray(jacobian @ sighting_covariance(sighting) @ jacobian.T)
