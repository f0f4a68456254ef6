"""How far the paths of a whole team lie from the true ones after one SE(2) motion of all of them together. Pure."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from deploy.evaluation.mrclam_truth import true_positions
from deploy.evaluation.tum import Trajectory, no_poses


@dataclass(frozen=True)
class TeamScore:
    """Root mean square distances [m]; NaN where nothing could be matched."""

    team_rmse_m: float  # over all poses of all robots
    robots_rmse_m: dict[str, float]
    matched: dict[str, int]  # poses that have a true position of their stamp, by robot
    expected: dict[str, int]  # poses of the run, by robot

    @property
    def largest_rmse_m(self) -> float:
        """Return the figure of the worst robot."""
        return max((rmse_m for rmse_m in self.robots_rmse_m.values() if not math.isnan(rmse_m)), default=math.nan)


def score_together(estimates: Mapping[str, Trajectory], truth: Mapping[str, Trajectory]) -> TeamScore:
    """Return the errors of all robots of the truth after the one motion of all estimates that makes their sum of squares smallest."""
    paths = {robot: estimates.get(robot, no_poses()) for robot in truth}
    pairs = {robot: _pairs(paths[robot], truth[robot]) for robot in truth}
    estimate, true = (np.concatenate([pair[side] for pair in pairs.values()]) for side in (0, 1))
    alignment = _Alignment(estimate, true)
    squares = {robot: np.abs(alignment.moved(own) - goal) ** 2 for robot, (own, goal) in pairs.items()}
    return TeamScore(
        team_rmse_m=_root_mean(np.concatenate(list(squares.values()))),
        robots_rmse_m={robot: _root_mean(each) for robot, each in squares.items()},
        matched={robot: len(each) for robot, each in squares.items()},
        expected={robot: len(paths[robot]) for robot in truth},
    )


def _pairs(estimate: Trajectory, truth: Trajectory) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """Return estimated and true positions, as x + iy, of the stamps at which the truth is known."""
    true = true_positions(truth, estimate.stamps_ns)
    known = np.isfinite(true[:, 0])
    return _complex(estimate.poses[known]), _complex(true[known])


class _Alignment:
    """The motion of estimates onto the truth: Umeyama, PAMI 1991, eq. 34 to 43, in the plane and without scale."""

    def __init__(self, estimate: NDArray[np.complex128], true: NDArray[np.complex128]) -> None:
        self._from = estimate.mean() if len(estimate) else 0.0
        self._to = true.mean() if len(true) else 0.0
        self._turn = np.exp(1j * np.angle(np.vdot(estimate - self._from, true - self._to)))

    def moved(self, positions: NDArray[np.complex128]) -> NDArray[np.complex128]:
        """Return estimated positions, in the frame of the truth."""
        return np.asarray(self._turn * (positions - self._from) + self._to)


def _complex(positions: NDArray[np.float64]) -> NDArray[np.complex128]:
    return np.asarray(positions[:, 0] + 1j * positions[:, 1])


def _root_mean(squares: NDArray[np.float64]) -> float:
    return float(np.sqrt(squares.mean())) if len(squares) else math.nan
