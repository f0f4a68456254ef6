"""Where one scan was taken as seen from another: point-to-line ICP with robust weights; what is not certain is no match.

Censi, "An ICP variant using a point-to-line metric", ICRA 2008, with the loss of Geman and McClure, which gives up what was pushed aside.
Along a single wall a scan may slide: what no piece tells keeps to the guess, and the covariance says so.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mapserver.mapping.poses.scan import STEP_M, Scan
from protocol.geometry import Array, Pose2

ITERATIONS = 12
SETTLED = 1e-5  # [m or rad]
SAME_FACING = 0.87  # cosine: pieces of one base line are turned by 30 degrees at most, so that nothing matches its own far side
REPEATED_M = 0.20  # along a base line the same error goes on for about so long
LOSS_SCALE = 2.0  # whitened residual at which a piece keeps a quarter of its weight
MOST_OFF = 3.0  # whitened residual of a piece that lies on its like
LOOSE_INFORMATION = np.eye(3) / 0.5**2  # [1/m^2, 1/m^2, 1/rad^2]: of what the base lines do not tell
LEAST_VARIANCE = np.full(3, 1e-6)  # 1 mm and 1 mrad: of errors that all base lines of a view have in common
LEAST_THINGS = 2  # of one alone nobody can tell whether it was pushed aside
LEAST_SHARE = 0.5  # of the pieces that need their like in the other scan
MOST_MISFIT = 1.0  # rms of the whitened residuals; more than their honest size is something else
GATES_M = 0.05, 0.10  # least and most that the guess may be wrong by
GATE_SIGMAS = 3.0
SAME_M = 0.01  # fits nearer to each other are one
RIVAL_SHARE = 0.8  # of as many pairs as the fit nearest to the guess has: fewer, and a fit is no rival
AROUND = [(0.6 * x, 0.6 * y) for x in (-1, 0, 1) for y in (-1, 0, 1) if x or y]  # where rivals are looked for, in gates


class Match(NamedTuple):
    """How a scan fits another."""

    reference_from_body: Pose2
    covariance: Array  # (3, 3) of the scan's own errors, in the body frame


class _Pairs(NamedTuple):
    """Pieces of a scan, and the pieces of the other that may be their like."""

    own: NDArray[np.intp]  # (n,) numbers in the scan
    facing: Array  # (n, 2) normals of the other's pieces, in the scan's body frame
    across_m: Array  # (n,) how far off they lie
    sigmas_m: Array  # (n,)

    def whitened(self) -> Array:
        """Return how far off they lie, (n,), in standard deviations."""
        return self.across_m / self.sigmas_m

    def lying_on(self) -> _Pairs:
        """Return those that lie on each other."""
        lies = np.abs(self.whitened()) < MOST_OFF
        return _Pairs(self.own[lies], self.facing[lies], self.across_m[lies], self.sigmas_m[lies])


class _Fit(NamedTuple):
    """Where ICP has ended."""

    pose: Pose2  # reference_from_body
    pairs: _Pairs


def certain_match(scan: Scan, reference: Scan, guess: Pose2, sigma_m: float) -> Match | None:
    """Return how a scan fits a reference near a guess known to `sigma_m`; None where it does not, or where it fits in two places."""
    if min(scan.count_things(), reference.count_things()) < LEAST_THINGS:
        return None
    gate_m = float(np.clip(GATE_SIGMAS * sigma_m, *GATES_M))
    best = _fit(scan, reference, guess, guess, gate_m)
    if best is None or _apart_m(guess, best.pose) > gate_m:
        return None
    for x, y in AROUND:
        rival = _fit(scan, reference, guess @ Pose2(x * gate_m, y * gate_m, 0.0), guess, gate_m)
        if rival is not None and len(rival.pairs.own) >= RIVAL_SHARE * len(best.pairs.own) and _apart_m(best.pose, rival.pose) > SAME_M:
            return None
    return Match(best.pose, _covariance(scan, best.pairs.own, best.pairs.facing))


def own_covariance(scan: Scan) -> Array:
    """Return the covariance, (3, 3) in the body frame, that the errors of a scan's own pieces give to whatever is matched with it."""
    return _covariance(scan, np.arange(len(scan.things)), scan.normals)


def _fit(scan: Scan, reference: Scan, start: Pose2, guess: Pose2, gate_m: float) -> _Fit | None:
    """Return where ICP from a start ends, held loosely by the guess; None where the scans do not fit there."""
    pose, pairs = start, _pairs(scan, reference, start, gate_m)
    for _ in range(ITERATIONS):
        jacobian = _jacobian(scan.points_m[pairs.own], pairs.facing)
        whitened = pairs.whitened()
        weighted = jacobian * (STEP_M / REPEATED_M / pairs.sigmas_m**2 / (1.0 + (whitened / LOSS_SCALE) ** 2) ** 2)[:, None]
        slope = weighted.T @ pairs.across_m + LOOSE_INFORMATION @ guess.between(pose).log()
        step = -np.linalg.solve(weighted.T @ jacobian + LOOSE_INFORMATION, slope)
        pose = pose @ Pose2.exp(step)
        pairs = _pairs(scan, reference, pose, gate_m)
        if np.abs(step).max() < SETTLED:
            break
    found = pairs.lying_on()
    return _Fit(pose, found) if _is_good(scan, found) else None


def _is_good(scan: Scan, pairs: _Pairs) -> bool:
    """Tell whether enough of a scan has its like in the other, and lies on it."""
    if len(pairs.own) < LEAST_SHARE * len(scan.things) or len(np.unique(scan.things[pairs.own])) < LEAST_THINGS:
        return False
    return float(np.mean(pairs.whitened() ** 2)) < MOST_MISFIT**2


def _pairs(scan: Scan, reference: Scan, reference_from_body: Pose2, gate_m: float) -> _Pairs:
    """Return the pieces that have their like within the gate, and the nearest one for each."""
    points_m, normals = reference_from_body.apply(scan.points_m), scan.normals @ reference_from_body.rotation().T
    offsets_m = points_m[:, None] - reference.points_m
    across_m = np.einsum("ijk,jk->ij", offsets_m, reference.normals)
    along_m = offsets_m[..., 1] * reference.normals[:, 0] - offsets_m[..., 0] * reference.normals[:, 1]
    is_like = (normals @ reference.normals.T > SAME_FACING) & (np.abs(along_m) < STEP_M) & (np.abs(across_m) < gate_m)
    own = np.flatnonzero(is_like.any(axis=1))
    like = np.where(is_like, np.abs(across_m), np.inf)[own].argmin(axis=1)
    sigmas_m = np.hypot(scan.sigmas_m[own], reference.sigmas_m[like])
    return _Pairs(own, reference.normals[like] @ reference_from_body.rotation(), across_m[own, like], sigmas_m)


def _covariance(scan: Scan, own: NDArray[np.intp], facing: Array) -> Array:
    jacobian = _jacobian(scan.points_m[own], facing)
    information = (jacobian * (STEP_M / REPEATED_M / scan.sigmas_m[own] ** 2)[:, None]).T @ jacobian
    return np.asarray(np.linalg.inv(information + LOOSE_INFORMATION) + np.diag(LEAST_VARIANCE))


def _jacobian(points_m: Array, facing: Array) -> Array:
    """Return how far points move across lines that face so, (n, 3), for a small motion of the body on the right."""
    return np.column_stack([facing, facing[:, 1] * points_m[:, 0] - facing[:, 0] * points_m[:, 1]])


def _apart_m(first: Pose2, second: Pose2) -> float:
    between = first.between(second)
    return float(np.hypot(between.x_m, between.y_m))
