"""What solves the pose graph: iSAM2 over a bounded number of variables; old ones are marginalised, so that memory stays bounded.

Kaess et al., "iSAM2: Incremental smoothing and mapping using the Bayes tree", IJRR 2012. What marginalised variables said of those
that stay remains as linear factors: Sibley et al., "Sliding window filter with application to planetary landing", JFR 2010, section 3.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import gtsam
import numpy as np

from mapserver.mapping.belief import Belief
from protocol.geometry import Array, Pose2


@dataclass(frozen=True)
class Effort:
    """How closely the graph is solved: what its sensors can tell is worth no more."""

    relinearise_above: float = 2e-3  # [m or rad]: so little is linear enough in a map of a few metres; the paths come out the same
    relinearise_every: int = 1  # solutions
    extra_iterations: int = 2  # at most; the robust weights settle within a few Gauss-Newton steps


class Solver:
    """Holds the factors and the estimate; `update` with new ones, `marginalise` old variables, read estimates at any time."""

    def __init__(self, effort: Effort | None = None) -> None:
        """Start with no variables."""
        self._effort = effort or Effort()
        self._isam = self._empty()

    def update(self, factors: gtsam.NonlinearFactorGraph, values: gtsam.Values) -> None:
        """Solve with new factors, and first values of the new variables; iterate until no variable needs to be linearised anew."""
        result = self._isam.update(factors, values)
        for _ in range(self._effort.extra_iterations):
            if result.getVariablesRelinearized() == 0:
                break
            result = self._isam.update()

    def marginalise(self, keys: Collection[int]) -> None:
        """Take variables out; what their factors say of the others stays, as linearised at the present estimate."""
        estimate = self._isam.calculateBestEstimate()
        leaving, staying, nonlinear = frozenset(keys), gtsam.NonlinearFactorGraph(), gtsam.NonlinearFactorGraph()
        for factor in _all(self._isam.getFactorsUnsafe()):
            (nonlinear if leaving.intersection(factor.keys()) else staying).add(factor)
        told = nonlinear.linearize(estimate)
        _, remaining = told.eliminatePartialSequential(_first_of(told, leaving))
        for number in range(remaining.size()):
            staying.add(gtsam.LinearContainerFactor(remaining.at(number), estimate))
        for key in leaving:
            estimate.erase(key)
        self._isam = self._empty()
        self._isam.update(staying, estimate)

    def has(self, key: int) -> bool:
        """Tell whether a variable has been solved for, and not marginalised since."""
        return bool(self._isam.valueExists(key))

    def pose(self, key: int) -> Pose2:
        """Return the estimate of a pose."""
        return from_gtsam(self._isam.calculateEstimatePose2(key))

    def point(self, key: int) -> Array:
        """Return the estimate of a point, shape (2,) [m; arena]."""
        return np.asarray(self._isam.calculateEstimatePoint2(key))

    def belief(self, key: int) -> Belief:
        """Return the estimate of a pose with its covariance."""
        return Belief(self.pose(key), self._isam.marginalCovariance(key))

    def _empty(self) -> gtsam.ISAM2:
        parameters = gtsam.ISAM2Params()
        parameters.setRelinearizeThreshold(self._effort.relinearise_above)
        parameters.relinearizeSkip = self._effort.relinearise_every
        return gtsam.ISAM2(parameters)


def to_gtsam(pose: Pose2) -> gtsam.Pose2:
    """Return a pose as GTSAM has it."""
    return gtsam.Pose2(*pose)


def from_gtsam(pose: gtsam.Pose2) -> Pose2:
    """Return a pose of GTSAM."""
    return Pose2(pose.x(), pose.y(), pose.theta())


def _first_of(factors: gtsam.GaussianFactorGraph, keys: Collection[int]) -> gtsam.Ordering:
    """Return these variables in an order in which they can be eliminated before all others, and with little fill-in."""
    ordering = gtsam.Ordering.ColamdConstrainedFirstGaussianFactorGraph(factors, list(keys), False)
    return gtsam.Ordering([ordering.at(place) for place in range(len(keys))])


def _all(factors: gtsam.NonlinearFactorGraph) -> list[gtsam.NonlinearFactor]:
    return [factors.at(number) for number in range(factors.size()) if factors.exists(number)]
