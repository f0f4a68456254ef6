"""How far estimated paths lie from the true ones. Pure functions; errors are estimate minus truth in the arena frame.

Nothing is aligned, so an error of the start counts, but for `aligned_rmse_m`, which takes out one SE(2) motion a robot.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from deploy.evaluation.tum import Trajectory

SAME_STAMP_NS = 1_000_000  # stamps this near mean the same frame: files round them, frames lie tens of milliseconds apart


class MeanMax(NamedTuple):
    """Mean and largest of absolute errors; NaN where nothing was measured."""

    mean: float
    max: float


@dataclass(frozen=True)
class MatchedPath:
    """The poses of one robot that have a true pose of the same stamp."""

    stamps_ns: NDArray[np.int64]  # (n,)
    estimate: NDArray[np.float64]  # (n, 3) [m, m, rad; arena]
    truth: NDArray[np.float64]  # (n, 3) [m, m, rad; arena]
    expected: int  # true poses, matched or not
    start_ns: int  # stamp of the first of them

    @property
    def errors(self) -> NDArray[np.float64]:
        """Return estimate minus truth, shape (n, 3) [m, m, rad; arena], the angle wrapped."""
        errors = self.estimate - self.truth
        errors[:, 2] = np.angle(np.exp(1j * errors[:, 2]))
        return errors


@dataclass(frozen=True)
class PathScore:
    """The path errors of one robot, or the mean over robots."""

    matched: int
    expected: int
    x_m: MeanMax
    y_m: MeanMax
    distance_m: MeanMax
    heading_rad: MeanMax
    aligned_rmse_m: float
    joined_s: float  # from the first true pose to the first estimated one: what a robot needed to find its place


def match_path(estimate: Trajectory, truth: Trajectory) -> MatchedPath:
    """Pair each true pose with the estimate of the same stamp; true poses without one are left out, and show in `expected`."""
    nearest = _nearest(estimate.stamps_ns, truth.stamps_ns)
    same = np.zeros(len(truth), dtype=bool)
    if len(estimate):
        same = np.abs(estimate.stamps_ns[nearest] - truth.stamps_ns) <= SAME_STAMP_NS
    return MatchedPath(truth.stamps_ns[same], estimate.poses[nearest[same]], truth.poses[same], len(truth), int(truth.stamps_ns[0]))


def score_path(path: MatchedPath) -> PathScore:
    """Return the errors of one robot's path; all NaN where no pose matched."""
    x_m, y_m, heading_rad = path.errors.T
    return PathScore(
        matched=len(path.stamps_ns),
        expected=path.expected,
        x_m=_mean_max(x_m),
        y_m=_mean_max(y_m),
        distance_m=_mean_max(np.hypot(x_m, y_m)),
        heading_rad=_mean_max(heading_rad),
        aligned_rmse_m=aligned_rmse_m(path),
        joined_s=1e-9 * int(path.stamps_ns[0] - path.start_ns) if len(path.stamps_ns) else math.nan,
    )


def mean_score(scores: Iterable[PathScore]) -> PathScore:
    """Return means of the robots' means and the largest of their maxima; a robot without any pose makes them NaN."""
    robots = list(scores)
    return PathScore(
        matched=sum(robot.matched for robot in robots),
        expected=sum(robot.expected for robot in robots),
        x_m=_over_robots(robot.x_m for robot in robots),
        y_m=_over_robots(robot.y_m for robot in robots),
        distance_m=_over_robots(robot.distance_m for robot in robots),
        heading_rad=_over_robots(robot.heading_rad for robot in robots),
        aligned_rmse_m=float(np.mean([robot.aligned_rmse_m for robot in robots])),
        joined_s=float(np.max([robot.joined_s for robot in robots])),
    )


def aligned_rmse_m(path: MatchedPath) -> float:
    """Return the root mean square distance [m] after the best SE(2) motion of the estimate onto the truth.

    Umeyama, "Least-squares estimation of transformation parameters between two point patterns", eq. 34 to 43 without the scale;
    in the plane the rotation is the angle of the summed products of centred points. NaN where no pose matched.
    """
    if not len(path.stamps_ns):
        return math.nan
    estimate, truth = (xy - xy.mean() for xy in (_complex(path.estimate), _complex(path.truth)))
    rotation = np.exp(1j * np.angle(np.vdot(estimate, truth)))
    return float(np.sqrt(np.mean(np.abs(rotation * estimate - truth) ** 2)))


def _complex(poses: NDArray[np.float64]) -> NDArray[np.complex128]:
    return poses[:, 0] + 1j * poses[:, 1]


def _nearest(stamps_ns: NDArray[np.int64], wanted_ns: NDArray[np.int64]) -> NDArray[np.intp]:
    """Return for each wanted stamp the index of the nearest of the growing `stamps_ns`."""
    last = max(len(stamps_ns) - 1, 0)
    after = np.clip(np.searchsorted(stamps_ns, wanted_ns), 0, last)
    if not len(stamps_ns):
        return after
    before = np.clip(after - 1, 0, last)
    return np.where(wanted_ns - stamps_ns[before] < stamps_ns[after] - wanted_ns, before, after)


def _mean_max(errors: NDArray[np.float64]) -> MeanMax:
    if not len(errors):
        return MeanMax(math.nan, math.nan)
    return MeanMax(float(np.abs(errors).mean()), float(np.abs(errors).max()))


def _over_robots(spreads: Iterable[MeanMax]) -> MeanMax:
    means, maxima = np.array(list(spreads)).T
    return MeanMax(float(means.mean()), float(maxima.max()))
