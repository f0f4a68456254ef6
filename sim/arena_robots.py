"""The robots of a random arena: the wedge in which they are to drive, the loose group in which they start, and how true they are."""

from __future__ import annotations

import math

import numpy as np

from protocol.geometry import Pose2
from sim.scenario_robots import RigTable, RobotTable, TruthTable

BODY_RADIUS_M = RigTable().body_radius_m
WEDGE_SPACING_M = 0.40  # from a robot to the next one behind it
WEDGE_ANGLE_RAD = math.radians(35.0)  # of the wedge's arms, from straight behind
WEDGE_RADIUS_M = WEDGE_SPACING_M * math.sin(WEDGE_ANGLE_RAD) + BODY_RADIUS_M  # half of what three robots in a wedge are wide

_START_SIGMA = (0.01, 0.01, math.radians(1.0))
_ROWS = (1, 2, 4, 5)  # robots in each row of the group
LARGEST_GROUP = sum(_ROWS)
_LOOSE_M, _LOOSE_RAD = 0.02, math.radians(5.0)  # largest distance of a start from its place in the group


def wedge_places(arena_from_leader: Pose2, robots: int) -> list[Pose2]:
    """Return where robots stand in the wedge, the leader first; the followers take its left and right arm in turn."""
    arms = [0.0, *(-WEDGE_ANGLE_RAD if index % 2 else WEDGE_ANGLE_RAD for index in range(1, robots))]
    along_m = [(index + 1) // 2 * WEDGE_SPACING_M for index in range(robots)]
    return [
        arena_from_leader @ Pose2(-length_m * math.cos(arm), -length_m * math.sin(arm), 0.0)
        for arm, length_m in zip(arms, along_m, strict=True)
    ]


def group_places(arena_from_leader: Pose2, robots: int) -> list[Pose2]:
    """Return where robots stand in a close group, the leader first: rows behind it, as far apart as in the wedge."""
    row_m, half_column_m = WEDGE_SPACING_M * math.cos(WEDGE_ANGLE_RAD), WEDGE_SPACING_M * math.sin(WEDGE_ANGLE_RAD)
    places = [
        Pose2(-rank * row_m, half_column_m * (width - 1 - 2 * place), 0.0) for rank, width in enumerate(_ROWS) for place in range(width)
    ]
    return [arena_from_leader @ place for place in places[:robots]]


def random_robots(rng: np.random.Generator, leader: Pose2, robots: int) -> tuple[RobotTable, ...]:
    """Return the robots r1 (which leads), r2, ... near their places, with wheels that are 1 % off."""
    return tuple(
        RobotTable(
            name=f"r{index + 1}", start=_loosely(rng, place) if index else place, start_sigma=_sigma(index), truth=_random_truth(rng)
        )
        for index, place in enumerate(group_places(leader, robots))
    )


def _sigma(index: int) -> tuple[float, float, float]:
    return _START_SIGMA if index else (0.0, 0.0, 0.0)


def _loosely(rng: np.random.Generator, place: Pose2) -> Pose2:
    x_m, y_m = rng.uniform(-_LOOSE_M, _LOOSE_M, 2).tolist()
    return place @ Pose2(x_m, y_m, rng.uniform(-_LOOSE_RAD, _LOOSE_RAD))


def _random_truth(rng: np.random.Generator) -> TruthTable:
    left, right, base = (1.0 + np.clip(rng.normal(0.0, 0.01, 3), -0.02, 0.02)).tolist()
    return TruthTable(left_wheel_scale=left, right_wheel_scale=right, wheel_base_scale=base)
