"""Where a robot without a place may be: poses that make points of its own frame the same as points of the arena, and what speaks for each.

Evidence is the logarithm of a likelihood ratio against sightings that show something else, wherever that is by chance. As a pose is chosen
to fit, its evidence is lessened by how small a part of all poses fits as well (Occam's factor by Laplace's method: MacKay,
"Information Theory, Inference, and Learning Algorithms", 2003, ch. 28).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mapserver.mapping.joining.pairings import Pairings
from protocol.geometry import Array, Pose2

ARENA_M2 = 100.0  # within such an area lies a robot of which nothing is known
LEAST_LEVER_M = 0.1  # two points that are nearer to each other tell no heading
FIT_SIGMAS = 3.0  # two points are as far apart in both frames, to so many standard deviations
CELL_M, CELL_RAD = 0.06, 0.1  # hypotheses that share a cell are one until they are fitted
MOST_SCORED, MOST_FITTED = 2000, 16  # of hypotheses; those that most pairs of points vote for are scored
LEAST_INFORMATION = 4.0  # in any direction: half a metre or half a radian; what is told worse is not told
FITS = 3  # iterations; a pair may fit better after the first


class Hypothesis(NamedTuple):
    """One pose of the seeker's frame."""

    arena_from_start: Pose2
    evidence: float  # [nats] for all of it, Occam's factor included
    covariance: Array  # (3, 3), on the right, for the seeker's pose at its last moment
    seen: int  # at so many moments others saw a robot where it was


def hypotheses_of(pairings: Pairings, start_from_body: Pose2) -> list[Hypothesis]:
    """Return where the seeker may be, the likeliest first; `start_from_body` is its pose at its last moment."""
    candidates = _most_voted(_from_two_points(pairings), start_from_body)
    if not len(candidates):
        return []
    evidence = _sum_of_slots(pairings, _values(pairings, candidates))
    best = np.argsort(-evidence, kind="stable")
    firsts = np.unique(_cells(candidates[best], start_from_body), axis=0, return_index=True)[1]
    kept = candidates[best[np.sort(firsts)[:MOST_FITTED]]]
    fitted = [_fit(pairings, Pose2(*pose), start_from_body) for pose in kept.tolist()]
    return sorted((each for each in fitted if each is not None), key=lambda each: -each.evidence)


def _from_two_points(pairings: Pairings) -> Array:
    """Return the poses arena_from_start, (h, 3), that follow from any two pairs: of one moment, or one of them of the last."""
    first, second = np.triu_indices(len(pairings), 1)
    at, last = pairings.moments, pairings.moments.max(initial=0)
    tell = (pairings.slots[first] != pairings.slots[second]) & ((at[first] == at[second]) | (at[second] == last))
    first, second = first[tell], second[tell]
    start, arena = _complex(pairings.start_m), _complex(pairings.arena_m)
    lever, turned = start[second] - start[first], arena[second] - arena[first]
    sigma_m = np.hypot(pairings.sigma_m[first], pairings.sigma_m[second])
    fits = (np.abs(lever) > LEAST_LEVER_M) & (np.abs(np.abs(lever) - np.abs(turned)) < FIT_SIGMAS * sigma_m)
    first, second, lever, turned = first[fits], second[fits], lever[fits], turned[fits]
    theta = np.angle(turned * lever.conj())
    origin = 0.5 * (arena[first] + arena[second] - np.exp(1j * theta) * (start[first] + start[second]))
    return np.stack([origin.real, origin.imag, theta], axis=1)


def _values(pairings: Pairings, poses: Array) -> Array:
    """Return what each pair adds to each pose's evidence if it is true, (h, n) [nats]; 0 where nothing speaks for it."""
    turn, origin = np.exp(1j * poses[:, 2]), poses[:, 0] + 1j * poses[:, 1]
    off_m = origin[:, None] + turn[:, None] * _complex(pairings.start_m) - _complex(pairings.arena_m)
    rivals = np.bincount(pairings.slots)[pairings.slots]
    most = np.log(np.maximum(pairings.chance_m2, 1e-12) / (2.0 * math.pi * pairings.sigma_m**2 * rivals))
    return np.asarray(np.maximum(most - 0.5 * (np.abs(off_m) / pairings.sigma_m) ** 2, 0.0))


def _sum_of_slots(pairings: Pairings, values: Array) -> Array:
    """Return the sum, (h,), over slots of the best pair's value."""
    firsts = np.flatnonzero(np.diff(pairings.slots, prepend=-1))
    return np.asarray(np.maximum.reduceat(values, firsts, axis=1).sum(axis=1))


def _most_voted(poses: Array, start_from_body: Pose2) -> Array:
    """Return the poses, (h, 3), in the fullest cells, at most `MOST_SCORED`."""
    if len(poses) <= MOST_SCORED:
        return poses
    _, owners, counts = np.unique(_cells(poses, start_from_body), axis=0, return_inverse=True, return_counts=True)
    return np.asarray(poses[np.argsort(-counts[owners.ravel()], kind="stable")[:MOST_SCORED]])


def _cells(poses: Array, start_from_body: Pose2) -> NDArray[np.int64]:
    """Return the cell of places and headings of the seeker, (h, 3), that each pose arena_from_start, (h, 3), leads to."""
    place = poses[:, 0] + 1j * poses[:, 1] + np.exp(1j * poses[:, 2]) * complex(*start_from_body[:2])
    cells = np.rint(np.stack([place.real / CELL_M, place.imag / CELL_M, poses[:, 2] / CELL_RAD], axis=1))
    return np.asarray(cells, dtype=np.int64)


def _fit(pairings: Pairings, pose: Pose2, start_from_body: Pose2) -> Hypothesis | None:
    """Return the pose fitted to the pairs that it makes the same; None where these do not tell a heading."""
    for _ in range(FITS):
        pairs = _true_pairs(pairings, pose)
        if len(pairs) < 2:
            return None
        pose = _aligned(pairings, pairs)
    pairs = _true_pairs(pairings, pose)
    information = _information(pairings, pairs, pose, start_from_body)
    told_in_each = np.linalg.eigvalsh(information)
    if len(pairs) < 2 or told_in_each[0] < LEAST_INFORMATION:
        return None
    covariance = np.asarray(np.linalg.inv(information), dtype=np.float64)
    told = float(_sum_of_slots(pairings, _values(pairings, np.array([pose])))[0])
    occam = 0.5 * float(np.sum(np.log(2.0 * math.pi / told_in_each))) - math.log(ARENA_M2 * 2.0 * math.pi)
    return Hypothesis(pose, told + occam, covariance, int(pairings.is_own[pairs].sum()))


def _true_pairs(pairings: Pairings, pose: Pose2) -> NDArray[np.intp]:
    """Return the best pair of each slot that any speaks for."""
    values = _values(pairings, np.array([pose]))[0]
    order = np.lexsort((-values, pairings.slots))
    best = order[np.flatnonzero(np.diff(pairings.slots[order], prepend=-1))]
    return np.asarray(best[values[best] > 0.0], dtype=np.intp)


def _aligned(pairings: Pairings, pairs: NDArray[np.intp]) -> Pose2:
    """Return the weighted least-squares motion of points onto points (Umeyama 1991, without the scale)."""
    start, arena = _complex(pairings.start_m[pairs]), _complex(pairings.arena_m[pairs])
    weights = pairings.sigma_m[pairs] ** -2
    start_mean, arena_mean = (np.average(points, weights=weights) for points in (start, arena))
    theta = float(np.angle(np.vdot(weights * (start - start_mean), arena - arena_mean)))
    origin = arena_mean - np.exp(1j * theta) * start_mean
    return Pose2(float(origin.real), float(origin.imag), theta)


def _information(pairings: Pairings, pairs: NDArray[np.intp], pose: Pose2, start_from_body: Pose2) -> Array:
    """Return the information, (3, 3), that pairs hold on the seeker's pose, for a perturbation on the right."""
    body_m = start_from_body.inverse().apply(pairings.start_m[pairs])
    information = np.zeros((3, 3))
    for (x_m, y_m), sigma_m in zip(body_m, pairings.sigma_m[pairs], strict=True):
        jacobian = np.array([[1.0, 0.0, -y_m], [0.0, 1.0, x_m]])
        information += jacobian.T @ jacobian / sigma_m**2
    return information


def _complex(points_m: Array) -> NDArray[np.complex128]:
    return np.asarray(points_m[:, 0] + 1j * points_m[:, 1], dtype=np.complex128)
