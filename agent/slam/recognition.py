"""Whether this is the floor of an old keyframe again, and where in it the robot is: one place, or none where two would do as well.

The alignment of floor_motion.py, started wherever the robot may be by now. What repeats itself, such as a grid, agrees at several of these
places: a wrong answer would bend the map, so then there is none.
"""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import NDArray

from agent.slam.floor_motion import Alignment, Glance, Keyframe, descend, smoothed
from protocol.geometry import Array, Pose2

REACH_SIGMAS = 3.0  # of the prediction, within which the robot is looked for
START_SPACING = np.array([0.02, 0.02, 0.06])  # [m, m, rad] between starts: from nearer ones the coarse alignment ends in the same place
MOST_STARTS = 27  # a robot that may be farther off is not looked for
WORST_GATE = 25.0  # squared sigmas of the prediction by which the place found may be off
LEAST_CORRELATION = 0.5  # less is another light, or another floor
RIVAL_SHARE = 0.85  # of the best correlation: another place that agrees so well makes both doubtful
MOST_OF_PREDICTION = 0.25  # of the prediction's variance may be left: else it was not the floor that told
PRIOR_WEIGHT = 0.1  # of the prediction, which shall hold the alignment and not take part in it


def recognise(keyframe: Keyframe, glance: Glance, predicted: Pose2, covariance: Array) -> Alignment | None:
    """Return where the body is in an old keyframe, given where it should be with its covariance, (3, 3) [m, m, rad; body].

    None where the floor is not the same, does not tell, or agrees in several places.
    """
    starts = _starts(predicted, covariance)
    information = PRIOR_WEIGHT * np.asarray(np.linalg.inv(covariance), np.float64)
    blurred = smoothed(glance)
    coarse = [descend(keyframe.coarse, blurred, start, predicted, information) for start in starts]
    places = _different([alignment for alignment in coarse if alignment is not None])[:2]
    fine = [descend(keyframe.fine, glance, place.keyframe_from_body, predicted, information) for place in places]
    found = sorted((each for each in fine if each is not None), key=lambda each: -each.correlation)
    if not found or not _is_believable(found[0], predicted, covariance):
        return None
    rivals = _different(found)[1:]
    return None if any(rival.correlation > RIVAL_SHARE * found[0].correlation for rival in rivals) else found[0]


def is_findable(covariance: Array) -> bool:
    """Tell whether a robot whose place is known so well, (3, 3) [m, m, rad; body], can be looked for."""
    return bool(np.prod(2 * _steps(covariance) + 1) <= MOST_STARTS)


def _steps(covariance: Array) -> NDArray[np.int64]:
    """Return how many starts are needed to either side, (3,) along x, y and theta."""
    reach = REACH_SIGMAS * np.sqrt(np.diag(covariance))
    return np.asarray(np.maximum(np.ceil((reach - 0.5 * START_SPACING) / START_SPACING), 0.0), np.int64)


def _starts(predicted: Pose2, covariance: Array) -> list[Pose2]:
    """Return poses about the predicted one from which every place within reach is found; none where that takes too many."""
    if not is_findable(covariance):
        return []
    offsets = product(*(np.arange(-count, count + 1) * spacing for count, spacing in zip(_steps(covariance), START_SPACING, strict=True)))
    return [predicted @ Pose2(*map(float, offset)) for offset in offsets]


def _different(found: list[Alignment]) -> list[Alignment]:
    """Return the best alignment of each place, best first; what lies within half the spacing of starts is one place."""
    places: list[Alignment] = []
    for each in sorted(found, key=lambda alignment: -alignment.correlation):
        apart = [np.abs(place.keyframe_from_body.between(each.keyframe_from_body).log()) / START_SPACING for place in places]
        if all(distance.max() > 0.5 for distance in apart):
            places.append(each)
    return places


def _is_believable(found: Alignment, predicted: Pose2, covariance: Array) -> bool:
    off = predicted.between(found.keyframe_from_body).log()
    is_near = float(off @ np.linalg.solve(covariance, off)) < WORST_GATE
    is_told = (np.diag(found.covariance) < MOST_OF_PREDICTION * np.diag(covariance)).all()
    return bool(is_near and is_told) and found.correlation > LEAST_CORRELATION
