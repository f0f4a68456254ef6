"""Where a robot is that may be anywhere: its floor is found again in the floor of places where it has been, from any side.

Marks of the texture are described by what is around them, turned as it is turned (ORB: Rublee et al., "ORB: an efficient alternative to
SIFT or SURF", ICCV 2011). One rigid motion has to explain many pairs of like marks: on a floor that repeats itself, such as a grid, marks
are like all others, and none does.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from agent.slam.floor_motion import Alignment, Glance, Keyframe, descend, smoothed
from agent.vision.floor_patch import FloorPatch
from protocol.geometry import Array, Pose2

MOST_MARKS = 400
OCTAVES = 4  # of scale 1.2, since floor looks softer the farther it lies from the camera
WIDTH_CELLS = 31  # of what is around a mark
SMOOTHING_CELLS = 1.0
GREY_PER_CONTRAST = 48.0
LEAST_STEP = 8  # grey levels between a mark and its surroundings
AGREEING_CELLS = 2.5  # marks agree with a motion that takes them so near to their likes
LEAST_AGREEING = 15  # chance, or a neighbouring mesh of a regular floor, has brought together 8
MOST_STRETCH = 0.03  # of a motion that should stretch nothing
LEAST_CORRELATION = 0.5  # of the alignment that begins there
FOUND = np.diag([0.01, 0.01, 0.02]) ** 2  # of what marks tell [m, m, rad]


class Marks(NamedTuple):
    """What the floor is known by."""

    places_m: Array  # (n, 2) [body]
    descriptors: NDArray[np.uint8]  # (n, 32)


def marks_of(patch: FloorPatch, glance: Glance) -> Marks:
    """Return the marks of the bare floor in a picture."""
    finder = cv2.ORB.create(MOST_MARKS, nlevels=OCTAVES, edgeThreshold=WIDTH_CELLS // 2, patchSize=WIDTH_CELLS, fastThreshold=LEAST_STEP)
    even = cv2.GaussianBlur(glance.cells, (0, 0), SMOOTHING_CELLS)
    grey = np.clip(128.0 + GREY_PER_CONTRAST * even, 0.0, 255.0).astype(np.uint8)
    points, descriptors = finder.detectAndCompute(grey, glance.bare.astype(np.uint8))
    if len(points) == 0:
        return Marks(np.empty((0, 2)), np.empty((0, 32), np.uint8))
    cells = np.array([point.pt for point in points])[:, ::-1]  # along x run the rows
    places_m = (cells - patch.half_cells) * patch.cell_m
    return Marks(places_m + glance.displacement_m(places_m), np.asarray(descriptors, np.uint8))


def find(known: Marks, keyframe: Keyframe, seen: Marks, glance: Glance, cell_m: float) -> Alignment | None:
    """Return where the body is in a keyframe, by its marks and then by all of its floor; None where this is another floor."""
    start = _motion_of(known, seen, cell_m)
    if start is None:
        return None
    information = np.asarray(np.linalg.inv(FOUND), np.float64)
    coarse = descend(keyframe.coarse, smoothed(glance), start, start, information)
    found = None if coarse is None else descend(keyframe.fine, glance, coarse.keyframe_from_body, start, information)
    return found if found is not None and found.correlation > LEAST_CORRELATION else None


def _motion_of(known: Marks, seen: Marks, cell_m: float) -> Pose2 | None:
    """Return known_from_seen, which many marks agree on; None where too few do."""
    if min(len(known.places_m), len(seen.places_m)) < LEAST_AGREEING:
        return None
    pairs = cv2.BFMatcher(cv2.NORM_HAMMING, crossCheck=True).match(seen.descriptors, known.descriptors)
    if len(pairs) < LEAST_AGREEING:
        return None
    there = known.places_m[[pair.trainIdx for pair in pairs]]
    here = seen.places_m[[pair.queryIdx for pair in pairs]]
    motion, agreeing = cv2.estimateAffinePartial2D(here, there, method=cv2.RANSAC, ransacReprojThreshold=AGREEING_CELLS * cell_m)
    if np.shape(motion) != (2, 3) or int(agreeing.sum()) < LEAST_AGREEING:
        return None
    (cos, _, x_m), (sin, _, y_m) = np.asarray(motion, np.float64).tolist()
    return None if abs(math.hypot(cos, sin) - 1.0) > MOST_STRETCH else Pose2(x_m, y_m, math.atan2(sin, cos))
